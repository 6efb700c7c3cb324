//! The files in an archive's `resources/`, and the models made from them.

use fmi2_export::Resources;
use formats::{Document, Matrix};
use vehicle_models::{Continuous, IdentifiedData, InputKind};

/// The document of that name, where the archive has it.
pub(crate) fn optional<D: Document>(
    resources: &Resources,
    name: &str,
) -> Result<Option<D>, String> {
    let Some(bytes) = resources.get(name) else { return Ok(None) };
    let text = std::str::from_utf8(bytes).map_err(|e| format!("{name}: not UTF-8 text: {e}"))?;
    D::from_json(text, name).map(Some).map_err(|e| format!("{e}; hint: {}", e.hint()))
}

/// The document of that name.
pub(crate) fn required<D: Document>(resources: &Resources, name: &str) -> Result<D, String> {
    optional(resources, name)?.ok_or_else(|| {
        format!("resources/{name} is missing; pack the archive again with `steerwright package`")
    })
}

/// The identified model's numbers.
pub(crate) fn identified_data(plant: &formats::Plant) -> IdentifiedData {
    let d = &plant.discrete;
    IdentifiedData {
        sample_time: d.sample_time_s,
        a: entries(&d.a),
        b: entries(&d.b),
        c: entries(&d.c),
        d: d.d.at(0, 0),
        k: entries(&d.k),
        continuous: plant.continuous.as_ref().map(|c| Continuous {
            f: entries(&c.f),
            g: entries(&c.g),
            h: entries(&c.h),
        }),
        input: match plant.input {
            formats::InputKind::Steering => InputKind::Steering,
            formats::InputKind::SteeringTimesSpeed => InputKind::SteeringTimesSpeed,
        },
        delay: plant.input_delay_s,
        steering_offset: plant.operating_point.steering_offset_rad,
        yaw_rate_offset: plant.operating_point.yaw_rate_offset_radps,
        speed: plant.operating_point.speed_mps,
        innovation_std: plant.noise.innovation_variance.sqrt(),
    }
}

/// The entries row by row.
fn entries(matrix: &Matrix) -> Vec<f64> {
    matrix.0.concat()
}
