//! The pose of the vehicle: an extended Kalman filter of GNSS fixes, a gyro with bias, and speed.
//!
//! States: position of the centre of gravity p = (X, Y), yaw ψ, gyro bias b. With the gyro's reading
//! g, the speed v and the sideslip's S, Q and C, over an interval of constant g and v,
//!
//! ```text
//! ψ̇ = r = g − b − n_r,   ḃ = n_b,   v_y = v·(Sₐ·r + C·ġ),   Sₐ = S + Q·(v·r)²
//! ṗ = R(ψ)·(v + n_v, v_y + n_l),        course = ψ + atan(Sₐ·(g − b))
//! fix = p + R(ψ)·antenna + gnss_std·(white, each axis),   p and ψ of the time it was valid
//! ```
//!
//! with white noises n of the densities in [`PoseParameters`]; R turns by an angle (Thrun, Burgard and
//! Fox, *Probabilistic Robotics*, 2005, chapters 3 and 5; Bar-Shalom, Li and Kirubarajan,
//! *Estimation with Applications to Tracking and Navigation*, 2001, for consistency and gates).
//! Readings are joined by straight lines: an interval has the mean of its two ends. The mean moves
//! along the exact arc, its Jacobian is that of the arc, and the noise is integrated for the
//! interval's mean velocity ([`filter`]).
//!
//! **New fixes.** A changed count is a new fix. Without a count, as with a plant's position in place
//! of a receiver, a fix is read from the inputs at the end of each step in which a `gnss_period`
//! ends.
//!
//! **Latency.** A fix is the position of the antenna `gnss_latency` ago. There are two filters, one
//! at that time and one at present, and the readings between them ([`history`]). A fix corrects the
//! first; the second is predicted from it with those readings. If the fix is at a communication
//! point, the estimate equals that of a filter without latency bit for bit.
//!
//! **Rejected fixes.** A fix with a standard deviation that is zero, negative or NaN is not used; a
//! standard deviation below 1 mm is raised to 1 mm. A fix whose normalised innovation squared exceeds
//! [`GATE`] is an outlier. After [`MOST_OUTLIERS`] in a row the filter restarts from the fix and
//! estimates the yaw by alignment: it compares the next fixes with the same drive by the gyro alone
//! ([`alignment`]). A start with an initial deviation of the yaw above half a radian does the same,
//! since the linearisation is invalid there.

pub mod alignment;
mod estimator;
pub mod filter;
pub mod history;
mod parameters;
mod saved;

pub use estimator::{GATE, MOST_OUTLIERS, PoseEstimator, PoseInput};
pub use parameters::PoseParameters;
pub use saved::SavedPose;
