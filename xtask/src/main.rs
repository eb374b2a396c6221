//! The project's commands. They order other programs, build and pack; nothing here steps a simulation.

mod abi;
mod chosts;
mod component;
mod demo;
mod digests;
mod examples;
mod fmu;
mod fuzz;
mod install;
mod needs;
mod release;
mod rotorburst;
mod sanitize;
mod site;
mod tests;
mod web;
mod wheel;

use xtask::{platforms, targets, tools};

use clap::{Parser, Subcommand};

/// Commands of the fabric project.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Set up everything, build the FMUs, fly a rotorburst fragment into a sheet of Zylon and write
    /// target/demo/report.html.
    Demo(demo::Options),
    /// Run what a change must pass: format, clippy, unit and physics tests, C and C++ hosts, FMPy, Python;
    /// with `--all` everything.
    Test(tests::Options),
    /// Print the Debian packages that `test` needs and that are not here, and in a second line those that it
    /// can use.
    Packages,
    /// Run the long checks: ensembles against the paper's numbers, full studies.
    Verify,
    /// Write target/fmu/FabricShield-fmi2.fmu and -fmi3.fmu.
    Fmu(fmu::Options),
    /// Build the rotorburst example as an SSP package, and compare it with the host in Python.
    Rotorburst(rotorburst::Options),
    /// Build the C and C++ library and install it with its headers, CMake package and pkg-config file.
    Install(install::Options),
    /// Build all that a release holds, from the commit that is checked out, in one folder: target/dist.
    Release(release::Options),
    /// Write include/fabric_kernel.h and tests/c/abi/scene.inc.
    Header,
    /// Run the same scenes on every target whose tools are here and compare their digests with
    /// tests/golden/pins.
    Digests(digests::Options),
    /// Write target/web/index.html: the kernel live in a web page.
    Web(web::Options),
    /// Write target/site/html/index.html: all pages and references as a site with a search, and an archive of
    /// it.
    Site,
    /// Measure ns per node-step, parts and peers; `python -m evidence bench` compares them with the goals.
    Bench(tests::BenchOptions),
    /// Build the Python package as wheels, and pack its source: target/wheels.
    Wheel,
    /// Fuzz scenes, images, C calls and FMI calls under AddressSanitizer.
    Fuzz(fuzz::Options),
    /// Write docs/tables/size.md: machine code, stack and memory of the library with few features.
    Size,
    /// Run the library's tests under AddressSanitizer, and those with threads under ThreadSanitizer.
    Sanitize,
}

fn main() -> std::process::ExitCode {
    tools::ended(match Arguments::parse().command {
        Command::Demo(options) => demo::run(&options),
        Command::Test(options) => tests::run(&options),
        Command::Packages => needs::packages(),
        Command::Verify => tests::verify(),
        Command::Fmu(options) => fmu::run(&options),
        Command::Rotorburst(options) => rotorburst::run(&options),
        Command::Install(options) => install::run(&options),
        Command::Release(options) => release::run(&options),
        Command::Site => site::run().map(|_| ()),
        Command::Header => tools::tables(&["header"]),
        Command::Digests(options) => digests::run(&options),
        Command::Web(options) => web::run(&options),
        Command::Bench(options) => tests::benchmark(&options.options),
        Command::Wheel => wheel::run(),
        Command::Fuzz(options) => fuzz::run(&options),
        Command::Size => tools::tables(&["size"]),
        Command::Sanitize => sanitize::run(),
    })
}
