//! `cargo xtask web`: the kernel for WebAssembly through the C interface, in one page without anything loaded
//! from elsewhere (web/, docs/web.md); and the page's test in a browser.

use crate::needs::BROWSERS;
use crate::tools::{
    Outcome, first_found, make_folder, read, run as command, said, step_left_out, target, top, wait, write,
};
use std::path::{Path, PathBuf};
use std::process::Command;

#[derive(clap::Args)]
pub struct Options {
    /// Also run the page's test in Chromium, as `cargo xtask test` does.
    #[arg(long)]
    test: bool,
    /// Also make the README's pictures: docs/images/web.png, the page in Chromium, and docs/images/movie.gif.
    #[arg(long)]
    pictures: bool,
}

pub fn run(options: &Options) -> Outcome {
    let out = build()?;
    if options.test {
        let component = crate::component::build_if_ready(&top(), &target().join("cross"))?.unwrap_or_default();
        node("test.mjs", &[browser()?, &out.to_string_lossy(), &program()?, &component.to_string_lossy()])?;
    }
    if options.pictures {
        let images = top().join("docs/images");
        node("picture.mjs", &[browser()?, &out.to_string_lossy(), &images.join("web.png").to_string_lossy()])?;
        movie(&images.join("movie.gif"))?;
    }
    Ok(())
}

/// The README's movie: until the fragment is through.
fn movie(path: &Path) -> Outcome {
    let folder = target().join("movie");
    let (scene, out) = ("examples/scenes/turbine_disc_sector.toml", folder.to_string_lossy());
    command(program()?, &["run", scene, "--movie", "--steps", "17000", "--until", "none", "--out", &out])?;
    let copied = std::fs::copy(folder.join("movie.gif"), path);
    copied.map(|_| ()).map_err(|error| format!("{}: {error}", path.display()))
}

/// The page's test, where what it needs is installed.
pub fn check() -> Outcome {
    let missing = crate::digests::module_ready().and(tools()).and(browser().map(|_| ()));
    if let Err(missing) = missing {
        return step_left_out(&missing);
    }
    run(&Options { test: true, pictures: false })
}

fn browser() -> Result<&'static str, String> {
    first_found(&BROWSERS).ok_or("no browser is here (Debian: chromium)".into())
}

fn tools() -> Outcome {
    let found = first_found(&["node"]).is_some() && first_found(&["npm"]).is_some();
    if found { Ok(()) } else { Err("node or npm is missing (Debian: nodejs npm)".into()) }
}

/// The program that runs scenes with the library of this machine.
fn program() -> Result<String, String> {
    Ok(crate::wheel::installed()?.with_file_name("fabric").to_string_lossy().into_owned())
}

/// Builds the page: its folder.
pub fn build() -> Result<PathBuf, String> {
    tools()?;
    let out = make_folder(target().join("web"))?;
    let kernel = out.join("kernel.wasm");
    crate::digests::module(&kernel)?;
    packages()?;
    in_web("node", &["node_modules/typescript/bin/tsc"])?;
    node("build.mjs", &[&kernel.to_string_lossy(), &program()?, &out.to_string_lossy()])?;
    Ok(out)
}

/// Installs what web/package-lock.json names, if it is not installed. No package may run a program of its
/// own.
fn packages() -> Outcome {
    let wanted = read(top().join("web/package-lock.json"))?;
    if wanted.contains("\"resolved\"") {
        return Err("web/package-lock.json names a registry: web/.npmrc keeps it out".into());
    }
    let stamp = top().join("web/node_modules/installed");
    if std::fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) {
        return Ok(());
    }
    said("Installing what web/package-lock.json names", || in_web("npm", &["ci", "--ignore-scripts", "--silent"]))?;
    write(&stamp, wanted)
}

fn node(program: &str, arguments: &[&str]) -> Outcome {
    in_web("node", &[&[program], arguments].concat())
}

/// Runs a program in the folder web.
fn in_web(program: &str, arguments: &[&str]) -> Outcome {
    wait(Command::new(program).args(arguments).current_dir(top().join("web")))
}
