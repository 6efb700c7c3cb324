//! The speed and the rate within which the dynamics of a vehicle are stepped.

/// Speed below which the dynamics are those of this speed, m/s; see [`crate::bicycle_plant`].
pub const BLEND_SPEED: f64 = 1.0;

/// Fastest mode that is stepped, 1/s.
pub const FASTEST_RATE: f64 = 1e5;
