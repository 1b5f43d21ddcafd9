//! `texmap-bindgen IN.wasm FOLDER NAME`: writes FOLDER/NAME.js and FOLDER/NAME_bg.wasm, an ES module for pages and Workers.

use std::env::args;
use std::process::ExitCode;

use wasm_bindgen_cli_support::Bindgen;

fn main() -> ExitCode {
    let [input, folder, name] = match args().skip(1).collect::<Vec<_>>().try_into() {
        Ok(names) => names,
        Err(_) => {
            eprintln!("usage: texmap-bindgen IN.wasm FOLDER NAME");
            return ExitCode::from(2);
        }
    };
    let mut bindgen = Bindgen::new();
    bindgen.input_path(input).out_name(&name).typescript(false);
    bindgen
        .remove_name_section(true)
        .remove_producers_section(true);
    let made = bindgen
        .web(true)
        .and_then(|bindgen| bindgen.generate(&folder));
    match made {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("texmap-bindgen: {error:#}");
            ExitCode::from(1)
        }
    }
}
