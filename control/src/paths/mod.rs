//! Reference paths in arc length: composed, standard roads, and from recorded points.
//!
//! `compose` joins straights, arcs and clothoids; `roads` and `road_file` make paths of them.
//! `recording` reads positions from tables, GPX and NMEA; `fitting` lays a path through them.

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
