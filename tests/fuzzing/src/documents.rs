//! The documents that inputs are made from, each with its FMU.

use steerwright_units::Fmu;

/// `plant.json`, its input delayed by no multiple of the sample time.
const DELAYED: &str = include_str!("../documents/plant-delayed.json");

/// The FMU and the document that a byte chooses: those of old as before, so that the corpora keep their meaning,
/// and the newest from what was left over.
pub(crate) fn chosen(byte: u8) -> (Fmu, &'static str) {
    const OF_OLD: [Fmu; 6] = [
        Fmu::IdentifiedPlant,
        Fmu::BicyclePlant,
        Fmu::LateralPid,
        Fmu::ReferencePath,
        Fmu::NonlinearVehicle,
        Fmu::PoseEstimator,
    ];
    let fmu = match byte {
        0..204 if byte % 6 == 1 => return (Fmu::IdentifiedPlant, DELAYED),
        0..204 => OF_OLD[usize::from((byte % 6).saturating_sub(1))],
        204..230 => Fmu::PoseEstimator,
        230.. => {
            let mut newer = Fmu::ALL.to_vec();
            newer.retain(|fmu| !OF_OLD.contains(fmu));
            newer[usize::from(byte - 230) % newer.len()]
        }
    };
    (fmu, fmu.example())
}
