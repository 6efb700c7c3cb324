//! The library of [`steerwright_bench_fmus::Empty`].
fmi2_export::export!(steerwright_bench_fmus::Empty);
