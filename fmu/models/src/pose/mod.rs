//! Where the vehicle is: an extended Kalman filter over GNSS fixes, a gyro with bias, and speed.
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
//! **When there is a fix.** A changed count is a new fix. Where nobody counts, as where a plant's
//! position is taken for that of an ideal receiver, `gnss_period` has one taken from the inputs at
//! the end of each step in which a period ends.
//!
//! **Latency.** A fix is where the antenna was `gnss_latency` ago. So two filters are kept, one
//! at that time and one at present, and the readings between them ([`history`]). A fix corrects the
//! first, and the second is made of it again by those readings: the estimate is to the last bit
//! that of a filter that had the fix in time, wherever the fix falls on a communication point.
//!
//! **Fixes that do not fit.** A fix with a standard deviation that is zero, negative or no number
//! is not used, one below 1 mm is taken for 1 mm. One whose normalised innovation squared is beyond
//! [`GATE`] is an outlier. After [`MOST_OUTLIERS`] in a row it is the filter that is wrong: it
//! starts again from the fix, and from there looks where the next ones lead ([`alignment`]), which
//! yields the yaw, compared with that of the same drive by the gyro alone, whatever it was taken for. A start
//! whose yaw is not known to half a radian does the same, since no linearisation reaches that far.

pub mod alignment;
mod estimator;
pub mod filter;
pub mod history;
mod parameters;
mod saved;

pub use estimator::{GATE, MOST_OUTLIERS, PoseEstimator, PoseInput};
pub use parameters::PoseParameters;
pub use saved::SavedPose;
