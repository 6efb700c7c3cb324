//! The vehicle that represents the truth: any plant FMU, or a file that one is packed from.

use crate::{Error, packed};
use std::path::Path;
use steerwright_control::DesignOptions;
use steerwright_formats::{Document, SourceFile, Vehicle};
use steerwright_host::{Archive, Causality, Kind, Value};

/// The parameters that a data sheet lacks for a vehicle at its limits.
const REST: &str = include_str!("../../examples/drives/multibody/vehicle.json");

/// See the module.
pub struct Truth {
    pub(crate) archive: Archive,
    pub(crate) source: SourceFile,
    /// A limitation to report.
    pub(crate) remark: Option<String>,
}

impl Truth {
    /// A plant FMU of any tool.
    ///
    /// # Errors
    /// An archive that cannot be opened, and [`Error::NoPlant`].
    pub fn from_fmu(path: &Path, bytes: &[u8]) -> Result<Self, Error> {
        let name = path.display().to_string();
        let archive = Archive::from_bytes(bytes, &name)?;
        check(&archive, &name)?;
        Ok(Self { archive, source: SourceFile::from_bytes(path, bytes), remark: None })
    }

    /// The FMU of `vehicle.json`, `plant.json` or `bicycle.json`.
    ///
    /// # Errors
    /// Those of packing, and [`Error::NoVehicle`].
    pub fn from_json(path: &Path, text: &str) -> Result<Self, Error> {
        Self::packed(path, text, text, None)
    }

    /// A NonlinearVehicle with vehicle data (TOML).
    ///
    /// # Errors
    /// Vehicle data that cannot be read, and those of packing.
    pub fn from_vehicle_data(path: &Path, text: &str) -> Result<Self, Error> {
        let name = SourceFile::from_bytes(path, text.as_bytes()).name;
        let (document, remark) = from_data(text, &path.display().to_string(), &name)?;
        Self::packed(path, text, &document, Some(remark))
    }

    fn packed(
        path: &Path,
        text: &str,
        document: &str,
        remark: Option<String>,
    ) -> Result<Self, Error> {
        let name = path.display().to_string();
        let packed = packed::pack(document, &name, None)?;
        if !packed.fmu.is_plant() {
            return Err(Error::NoVehicle { file: name, fmu: packed.fmu.name() });
        }
        let source = SourceFile::from_bytes(path, text.as_bytes());
        Ok(Self { archive: Archive::from_bytes(&packed.bytes, &name)?, source, remark })
    }
}

/// A vehicle with the data of a bicycle model, and the tyres and measures of the one that comes with
/// this program.
fn from_data(text: &str, path: &str, name: &str) -> Result<(String, String), Error> {
    let data = steerwright_control::bicycle_from_toml(text, path)?.vehicle;
    let mut vehicle = Vehicle::from_json(REST, "vehicle.json of the multi-body drive")?;
    let other = vehicle.name.clone();
    vehicle.name.clone_from(&data.name);
    vehicle.speed_mps = data.speed_mps;
    let (body, tyres, actuator) = (&mut vehicle.body, &mut vehicle.tyres, &mut vehicle.actuator);
    data.give_to(body, tyres, actuator);
    let rate = if data.actuator_rate_max_radps.is_some() {
        String::new()
    } else {
        let rate = actuator.road_wheel_rate_max_radps.to_degrees();
        format!(", steering rate ({rate:.1} deg/s at the road wheel)")
    };
    let remark = format!(
        "{name} has no friction ({} assumed), tyre curves, height, track width, roll{rate}: they are those of the \
         {other}; a vehicle.json states them",
        tyres.friction_coefficient
    );
    Ok((vehicle.to_json(), remark))
}

/// The limits of a plant's steering that an archive states, in steering coordinates; a controller has more and always states
/// them ([`steerwright_formats::Limits`]).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Limits {
    pub(crate) angle_rad: Option<f64>,
    pub(crate) rate_radps: Option<f64>,
}

/// The limits that a vehicle states: as parameters of a NonlinearVehicle, in its coordinates or in
/// those of the road wheel, and as bounds of its input.
pub(crate) fn limits(archive: &Archive) -> Limits {
    let start = |name: &str| match archive.model().variable(name)?.start {
        Some(Value::Real(value)) if value.is_finite() && value > 0.0 => Some(value),
        _ => None,
    };
    let ratio = start("steering_ratio").unwrap_or(1.0);
    let stated = |steering: &str, wheel: &str| {
        start(steering).or_else(|| start(wheel).map(|value| ratio * value))
    };
    let bound = archive.model().variable("steering_angle").and_then(|input| {
        let low = input.min.map(f64::abs).filter(|low| *low > 0.0);
        input.max.filter(|high| *high > 0.0).map(|high| low.map_or(high, |low| low.min(high)))
    });
    let angle = stated("steering_angle_max", "road_wheel_angle_max");
    Limits {
        angle_rad: angle.into_iter().chain(bound).reduce(f64::min),
        rate_radps: stated("steering_rate_max", "road_wheel_rate_max"),
    }
}

impl Limits {
    /// Options of a design that keeps to these limits too, and what that changes. `ratio` is the
    /// models' steering ratio.
    pub(crate) fn applied(
        self,
        requested: &DesignOptions,
        ratio: f64,
    ) -> (DesignOptions, Option<String>) {
        let mut options = *requested;
        let mut changed = Vec::new();
        let usual_angle = steerwright_control::usual_max_angle_rad(ratio);
        if let Some(limit) = self.angle_rad
            && limit < requested.max_angle_rad.unwrap_or(usual_angle)
        {
            options.max_angle_rad = Some(limit);
            changed.push(format!("{:.1} deg", limit.to_degrees()));
        }
        if let Some(limit) = self.rate_radps
            && requested.max_rate_radps.is_none_or(|rate| limit < rate)
        {
            options.max_rate_radps = Some(limit);
            changed.push(format!("{:.1} deg/s", limit.to_degrees()));
        }
        let text = format!(
            "controllers that are designed here keep to the truth's steering limit of {}",
            changed.join(" and ")
        );
        (options, (!changed.is_empty()).then_some(text))
    }
}

/// A warning where the steps are not those that the vehicle recommends.
pub(crate) fn step_remark(archive: &Archive, step: f64) -> Option<String> {
    let model = archive.model();
    let own = model.description().default_experiment?.step_size?;
    let differs = (own - step).abs() > 1e-9 * step;
    let any = model.co_simulation().can_handle_variable_communication_step_size;
    if differs && !any {
        Some(format!(
            "the truth recommends steps of {own} s and is stepped every {step} s, as the controllers"
        ))
    } else {
        None
    }
}

/// Whether the FMU has the words of a plant.
fn check(archive: &Archive, name: &str) -> Result<(), Error> {
    let model = archive.model();
    let has = |name: &str, causalities: &[Causality]| {
        let real = |v: &&steerwright_host::Variable| v.kind == Kind::Real;
        model.variable(name).filter(real).is_some_and(|v| causalities.contains(&v.causality))
    };
    let mut missing: Vec<String> = Vec::new();
    if !has("steering_angle", &[Causality::Input]) {
        missing.push("input steering_angle (rad)".into());
    }
    if !has("speed", &[Causality::Input, Causality::Parameter]) {
        missing.push("input speed (m/s)".into());
    }
    for (output, unit) in [("x", "m"), ("y", "m"), ("yaw", "rad")] {
        if !has(output, &[Causality::Output]) {
            missing.push(format!("output {output} ({unit})"));
        }
    }
    if missing.is_empty() {
        return Ok(());
    }
    let of = |causality| {
        let all = model.variables().iter().filter(|v| v.causality == causality);
        let mut names: Vec<&str> = all.map(|v| v.name.as_str()).collect();
        let more = names.len().saturating_sub(12);
        names.truncate(12);
        let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
        format!("{}{rest}", names.join(", "))
    };
    Err(Error::NoPlant {
        file: name.into(),
        missing,
        inputs: of(Causality::Input),
        outputs: of(Causality::Output),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const DATA: &str = include_str!("../../examples/drives/multibody/vehicle.toml");

    #[test]
    fn a_stated_rate_of_the_steering_is_that_of_the_vehicle() {
        let (document, remark) = from_data(DATA, "vehicle.toml", "vehicle.toml").unwrap();
        let without = Vehicle::from_json(&document, "vehicle.json").unwrap();
        assert!(remark.contains("steering rate"), "{remark}");
        let stated = format!("{DATA}\nactuator_rate_max_radps = 0.123\n");
        let (document, remark) = from_data(&stated, "vehicle.toml", "vehicle.toml").unwrap();
        let vehicle = Vehicle::from_json(&document, "vehicle.json").unwrap();
        assert!(!remark.contains("steering rate"), "{remark}");
        assert_eq!(vehicle.actuator.road_wheel_rate_max_radps, 0.123);
        assert_eq!(vehicle.tyres, without.tyres);
        assert_eq!(vehicle.body, without.body);
    }
}
