//! Reference paths in arc length: composed, standard roads, and from recorded points.

mod compose;
mod fitting;
mod recording;
mod road_file;
mod roads;

pub use compose::PathComposer;
pub use fitting::options::{Excess, PointOptions, RecordedPath};
pub use fitting::{from_points, path_from_recording};
pub use recording::fixes::{FixOptions, PoorFixes, RecordedPoints};
pub use recording::read_points;
pub use road_file::path_from_road;
pub use roads::{RoadOptions, double_lane_change, reference_road, s_curve};
