// Package and FMU name of each library: the one list, included by the build script beside it and by
// `cargo xtask cross`.
[
    ("identified-plant", "IdentifiedPlant"),
    ("bicycle-plant", "BicyclePlant"),
    ("nonlinear-vehicle", "NonlinearVehicle"),
    ("lateral-pid", "LateralPid"),
    ("reference-path", "ReferencePath"),
    ("pose-estimator", "PoseEstimator"),
]
