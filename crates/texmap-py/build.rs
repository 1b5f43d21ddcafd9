//! macOS links a module of Python with symbols that its interpreter brings.
fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
