//! Drive logs: files of any tool → channels with units on one clock → segments on one uniform grid.
//!
//! | format | channels |
//! |---|---|
//! | CSV of any dialect, plain or compressed as a whole (gzip, Zstandard, bzip2, ZIP) | its columns |
//! | MDF 4 and 3 | its channels, and the signals of its CAN frames by DBC databases |
//! | MCAP | the numbers in messages of ROS 2 or in JSON |
//! | Parquet, Arrow (Feather) | its columns |
//! | CAN logs as text (candump, Vector ASC, PEAK TRC, BUSMASTER, Kvaser, CSV of cabana, SavvyCAN, python-can, Vehicle Spy, CANedge, CL2000), plain or compressed as a whole (gzip, Zstandard, bzip2, ZIP) | the signals of their frames by DBC databases |
//!
//! A format is recognised by the first bytes of the file and read as a [`Recording`]. [`read_log`] brings its
//! channels onto one grid as a [`DriveLog`], in as many segments as drives, gaps and windows make of it; [`stream`]
//! does so piece by piece in memory that does not grow with the file. SI and radians, ISO 8855 signs. Faults that
//! the log alone shows are handled on the way and reported: spikes, dropouts, frozen runs, repeated stamps, gaps.
//!
//! ```
//! # fn main() -> Result<(), steerwright_drivelog::Error> {
//! let mut csv = String::from("time_s,roadwheel_command_rad,yaw_rate_radps,speed_mps\n");
//! for k in 0..300 {
//!     let t = 0.01 * k as f64;
//!     csv += &format!("{t:.2},{:.6},{:.6},15\n", 0.03 * t.sin(), 0.1 * (t - 0.1).sin());
//! }
//! let files = [("drive.csv".to_string(), csv.into_bytes())];
//! let log = steerwright_drivelog::read_log(&files, &steerwright_drivelog::LogOptions::default())?;
//! assert_eq!(log.segments.len(), 1);
//! # Ok(())
//! # }
//! ```
//!
//! This crate opens no files and contains no models.

mod assemble;
mod channel_units;
mod channels;
mod delayed;
mod drive;
mod error;
mod expression;
mod faults;
mod formats;
mod gnss;
mod inspect;
mod intersample;
mod log;
mod mapping;
mod mapping_file;
mod names;
mod noise;
mod options;
mod read;
mod recording;
mod resample;
mod role;
mod segments;
mod series;
pub mod signal;
mod stream;
mod units;

pub use error::{Error, Place};
pub use formats::LOG_FORMATS;
pub use gnss::{Gnss, GnssDrive};
pub use inspect::{InspectedChannel, InspectedGroup, Inspection, inspect};
pub use log::{DriveLog, Segment, below_speed_in_words};
pub use mapping_file::Mapping;
pub use options::{DecimalMark, LogOptions, Response, VehicleClass};
pub use read::{read_drives, read_log, read_recordings};
pub use recording::{
    Channel, Columns, Dates, Group, LogFile, Pieces, ReadAt, Recording, Request, Rows, Wanted,
    in_memory, open,
};
pub use role::Role;
pub use steerwright_formats::Intersample;
pub use stream::{Gate, Piece, Sink, StreamStart, Streamed, stream};
pub use units::without_unit;
