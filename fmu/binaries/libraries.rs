// Folder and FMU name of each library, whose package is `steerwright-` and the folder: the one list, included by
// the build script next to it and by `cargo xtask cross`.
[
    ("identified-plant", "IdentifiedPlant"),
    ("bicycle-plant", "BicyclePlant"),
    ("nonlinear-vehicle", "NonlinearVehicle"),
    ("longitudinal-plant", "LongitudinalPlant"),
    ("lateral-pid", "LateralPid"),
    ("reference-path", "ReferencePath"),
    ("pose-estimator", "PoseEstimator"),
]
