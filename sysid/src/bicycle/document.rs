//! `bicycle.json` of an identified vehicle.

use formats::{
    Bicycle, BicycleCoefficients, BicycleEvidence, Document, Matrix, Provenance, Quality,
    VehicleData,
};

/// Eq 13 of a vehicle, as `control::bicycle` writes it.
pub(super) fn document(
    vehicle: VehicleData,
    evidence: BicycleEvidence,
    quality: Quality,
    provenance: Provenance,
) -> Bicycle {
    let (m, j, v) = (vehicle.mass_kg, vehicle.yaw_inertia_kgm2, vehicle.speed_mps);
    let (lf, lr) = (vehicle.distance_front_m, vehicle.distance_rear_m);
    let (cf, cr) = (vehicle.cornering_stiffness_front_npr, vehicle.cornering_stiffness_rear_npr);
    let k = BicycleCoefficients {
        a1: -(cf + cr) / m,
        a2: -(cf * lf - cr * lr) / m,
        a3: (-cf * lf + cr * lr) / j,
        a4: -(cf * lf * lf + cr * lr * lr) / j,
        b1: cf / m,
        b2: cf * lf / j,
        n: 1.0 / vehicle.steering_ratio,
        tn: vehicle.actuator_time_constant_s,
    };
    #[rustfmt::skip]
    let rows = [
        [0.0, 1.0,      0.0,   0.0,      0.0],
        [0.0, k.a1 / v, -k.a1, k.a2 / v, k.b1 * k.n],
        [0.0, 0.0,      0.0,   1.0,      0.0],
        [0.0, k.a3 / v, -k.a3, k.a4 / v, k.b2 * k.n],
        [0.0, 0.0,      0.0,   0.0,      -1.0 / k.tn],
    ];
    Bicycle {
        schema: Bicycle::SCHEMA.into(),
        vehicle,
        coefficients: k,
        state_matrix: Matrix::from_fn(5, 5, |i, j| rows[i][j]),
        input_matrix: Matrix::column(&[0.0, 0.0, 0.0, 0.0, 1.0 / k.tn]),
        evidence: Some(evidence),
        quality,
        provenance,
    }
}
