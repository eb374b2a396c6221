//! Files made of the tables in code for FMUs and the documents: model descriptions, the page in the
//! archives, parameter sets, the tables of parameters and outputs, the types of the Python package.

mod description;
mod outputs;
mod page;
mod parameters;
mod xml;

/// Path below the top folder, and text.
///
/// # Errors
/// A scene that is refused, or a file of Python without a place for the types: what is wrong.
pub fn files() -> xtask::tools::Outcome<Vec<(String, String)>> {
    let tables = [
        ("modelDescription/fmi2.xml".into(), description::fmi2()),
        ("modelDescription/fmi3.xml".into(), description::fmi3()),
        ("modelDescription/documentation/index.html".into(), page::page()),
        ("docs/tables/scene.md".into(), parameters::table()),
        ("docs/tables/outputs.md".into(), outputs::table()),
    ];
    Ok(tables.into_iter().chain(parameters::sets()?).chain([outputs::types()?]).collect())
}
