//! The pictures in an archive; each PNG is made from the SVG next to it (`tests/icons.rs`).

use steerwright_units::Fmu;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Icon {
    /// Pixels.
    pub(crate) png: &'static [u8],
    /// The drawing.
    pub(crate) svg: &'static [u8],
}

macro_rules! icon {
    ($name:literal) => {
        Icon {
            png: include_bytes!(concat!("../icons/", $name, ".png")),
            svg: include_bytes!(concat!("../icons/", $name, ".svg")),
        }
    };
}

pub(crate) const fn icon(fmu: Fmu) -> Icon {
    match fmu {
        Fmu::IdentifiedPlant => icon!("IdentifiedPlant"),
        Fmu::BicyclePlant => icon!("BicyclePlant"),
        Fmu::NonlinearVehicle => icon!("NonlinearVehicle"),
        Fmu::LongitudinalPlant => icon!("LongitudinalPlant"),
        Fmu::LateralPid => icon!("LateralPid"),
        Fmu::ReferencePath => icon!("ReferencePath"),
        Fmu::PoseEstimator => icon!("PoseEstimator"),
    }
}

pub(crate) const TERMINAL: Icon = icon!("terminal");
