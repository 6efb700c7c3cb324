#![doc = include_str!("../README.md")]

fmi2_export::export!(steerwright_units::LongitudinalPlant);
