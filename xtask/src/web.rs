//! `cargo xtask web`: the kernel for WebAssembly through the C interface, in one page without anything loaded
//! from elsewhere (web/, docs/web.md); and the page's test in a browser.

use crate::component::build_if_ready;
use crate::needs::BROWSERS;
use crate::tools::{Context as _, Outcome, ensure, first_found, said, sh, shell, step_left_out, target};
use std::path::{Path, PathBuf};

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
        let (browser, program, component) = (browser()?, program()?, build_if_ready()?.unwrap_or_default());
        sh!("node web/test.mjs {browser} {out} {program} {component}").run()?;
    }
    if options.pictures {
        let browser = browser()?;
        sh!("node web/picture.mjs {browser} {out} docs/images/web.png").run()?;
        movie(Path::new("docs/images/movie.gif"))?;
    }
    Ok(())
}

/// The README's movie: until the fragment is through.
fn movie(path: &Path) -> Outcome {
    let (folder, program) = (target().join("movie"), program()?);
    let scene = "examples/scenes/turbine_disc_sector.toml";
    sh!("{program} run {scene} --movie --steps 17000 --until none --out {folder}").run()?;
    Ok(shell().copy_file(folder.join("movie.gif"), path)?)
}

/// The page's test, where what it needs is installed.
pub fn check() -> Outcome {
    let missing = crate::digests::module_ready().and_then(|()| tools()).and_then(|()| browser());
    if let Err(missing) = missing {
        return step_left_out(&missing.to_string());
    }
    run(&Options { test: true, pictures: false })
}

fn browser() -> Outcome<&'static str> {
    first_found(&BROWSERS).context("no browser is here (Debian: chromium)")
}

fn tools() -> Outcome {
    let found = first_found(&["node"]).is_some() && first_found(&["npm"]).is_some();
    ensure!(found, "node or npm is missing (Debian: nodejs npm)");
    Ok(())
}

/// The program that runs scenes with the library of this machine.
fn program() -> Outcome<PathBuf> {
    Ok(crate::wheel::installed()?.with_file_name("fabric"))
}

/// Builds the page: its folder.
pub fn build() -> Outcome<PathBuf> {
    tools()?;
    let out = shell().create_dir(target().join("web"))?;
    let (kernel, program) = (out.join("kernel.wasm"), program()?);
    crate::digests::module(&kernel)?;
    packages()?;
    sh!("node web/node_modules/typescript/bin/tsc -p web").run()?;
    sh!("node web/build.mjs {kernel} {program} {out}").run()?;
    Ok(out)
}

/// Installs what web/package-lock.json names, if it is not installed. No package may run a program of its
/// own.
fn packages() -> Outcome {
    let wanted = shell().read_file("web/package-lock.json")?;
    let named = wanted.contains("\"resolved\"");
    ensure!(!named, "web/package-lock.json names a registry: web/.npmrc keeps it out");
    let stamp = "web/node_modules/installed";
    if shell().read_file(stamp).is_ok_and(|installed| installed == wanted) {
        return Ok(());
    }
    let install = sh!("npm --prefix web ci --ignore-scripts --silent");
    said("Installing what web/package-lock.json names", || Ok(install.run()?))?;
    Ok(shell().write_file(stamp, wanted)?)
}
