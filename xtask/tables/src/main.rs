//! xtask-tables: what is made of the tables in code, and what is checked in compiled libraries.

mod check;
mod description;
mod gates;
mod header;
mod model;
mod outputs;
mod page;
mod parameters;
mod size;
mod stack;
mod xml;

use model::Model;
use std::path::{Path, PathBuf};
use xtask::tools::{Outcome, made, top};

fn main() -> std::process::ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    xtask::tools::ended(run(&words.iter().map(String::as_str).collect::<Vec<_>>()))
}

fn run(words: &[&str]) -> Outcome {
    match words {
        ["header", check @ ..] => header::run(check == ["--check"]),
        ["fmu", check @ ..] => fmu(check == ["--check"]),
        // The files of a model of a scene; the scene as its library is compiled with it is printed.
        ["model", name, scene, folder] => {
            let model = Model::of(name, scene.as_ref())?;
            made(&files(&model, folder.as_ref()), false, "")?;
            println!("{}", model.words.unwrap_or_default());
            Ok(())
        }
        ["check", libraries @ ..] => check::run(libraries),
        ["gates"] => gates::run(),
        ["features"] => gates::every_feature_set(),
        ["size"] => size::run(),
        _ => Err(format!("unknown: {words:?}")),
    }
}

/// What `cargo xtask fmu` makes of the tables, or the comparison with what is committed.
fn fmu(check: bool) -> Outcome {
    let mut files = files(&Model::own(), &top().join("modelDescription"));
    let tables =
        [("docs/tables/scene.md".into(), parameters::table()), ("docs/tables/outputs.md".into(), outputs::table())];
    let others = parameters::sets()?.into_iter().chain(tables).chain([outputs::types()?]);
    files.extend(others.map(|(name, text)| (top().join(name), text)));
    made(&files, check, "cargo xtask fmu")
}

/// The files that are made for a model in a folder, and their texts.
fn files(model: &Model, folder: &Path) -> Vec<(PathBuf, String)> {
    let names = ["fmi2.xml", "fmi3.xml", "documentation/index.html"];
    let texts = [description::fmi2(model), description::fmi3(model), page::page(model)];
    names.into_iter().map(|name| folder.join(name)).zip(texts).collect()
}
