//! Lets symbols of Python stay open on macOS, whose linker refuses them otherwise.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
