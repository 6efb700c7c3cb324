//! Reference paths in arc length: composed, standard roads, and from recorded points.

mod compose;
mod fixes;
mod geodesy;
mod gpx;
mod nmea;
mod outliers;
mod points;
mod primitives;
mod read;
mod roads;
mod spline;

pub use compose::PathComposer;
pub use fixes::{FixOptions, PoorFixes};
pub use points::{Excess, PointOptions, RecordedPath, from_points};
pub use primitives::path_from_road;
pub use read::{RecordedPoints, path_from_recording, read_points};
pub use roads::{RoadOptions, double_lane_change, reference_road, s_curve};
