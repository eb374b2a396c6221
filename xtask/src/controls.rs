//! `cargo xtask digests --controls`: deliberate changes of the kernel, one at a time in a copy of the source. Each must change a
//! digest of tests/golden/digests, or the digests would not notice such a thing.

use crate::digests::{build_checkout, lines, pins, run_here};
use crate::records::{self, Figure};
use crate::tools::{Outcome, output, target, top};
use std::path::{Path, PathBuf};

/// One change.
struct Control {
    what: &'static str,
    file: &'static str,
    /// Text that the file holds once.
    text: &'static str,
    replacement: &'static str,
    /// A scene that it must not touch, which shows that the change is what it says; empty for none.
    spared: &'static str,
}

const CONTROLS: [Control; 8] = [
    Control {
        what: "a fused multiply-add where the projectile drifts",
        file: "kernel/src/projectile.rs",
        text: "self.position += self.velocity * dt;",
        replacement: "self.position = self.position.zip_map(&self.velocity, |x, v| libm::fma(v, dt, x));",
        spared: "prescribed",
    },
    Control {
        what: "a fused multiply-add in the damage law",
        file: "kernel/src/yarn.rs",
        text: "self.a * (math::exp(-damage_rate * beyond) - self.b);",
        replacement: "libm::fma(self.a, math::exp(-damage_rate * beyond), -self.a * self.b);",
        // Its offset is 0 and its factor 1.
        spared: "sphere",
    },
    Control {
        what: "a reordered sum of a node's forces",
        file: "kernel/src/sweep.rs",
        text: "right.sub(left).add(vertical)",
        replacement: "vertical.sub(left).add(right)",
        spared: "",
    },
    Control {
        what: "contact solved from the last node to the first",
        file: "kernel/src/contact.rs",
        text: "let mut largest_change = 0.0;\n        for slot in candidates.iter_mut() {",
        replacement: "let mut largest_change = 0.0;\n        for slot in candidates.iter_mut().rev() {",
        spared: "",
    },
    Control {
        what: "another exponential: 1/exp(-x)",
        file: "kernel/src/math.rs",
        text: "libm::exp(x)",
        replacement: "1.0 / libm::exp(-x)",
        spared: "theta",
    },
    Control {
        what: "-0.0 instead of 0.0 for a velocity at rest",
        file: "kernel/src/lanes.rs",
        text: "if self < limit && self > -limit { 0.0 } else { self }",
        replacement: "if self < limit && self > -limit { -0.0 } else { self }",
        spared: "",
    },
    Control {
        what: "the last bit of a velocity, only after the first failure",
        file: "kernel/src/explicit.rs",
        text: "let failed_before = self.failed_segments;",
        replacement: "let failed_before = self.failed_segments;\n        if failed_before > 0 {\n            \
                      let z = &mut self.state.body.velocity.z;\n            *z = f64::from_bits(z.to_bits() ^ 1);\n        }",
        // Nothing fails in it.
        spared: "theta",
    },
    Control {
        what: "the draws of the next segment",
        file: "kernel/src/random.rs",
        text: "wrapping_add(splitmix64(label))",
        replacement: "wrapping_add(splitmix64(label.wrapping_add(4)))",
        // Its yarn is uniform.
        spared: "quarter",
    },
];

/// Builds and runs the copy as it is, which must print the pins, then with each change; prints a table.
pub fn run() -> Outcome {
    let copy = copied()?;
    let pins = pins()?;
    let digests = || run_here(&build_checkout(&copy)?).map(|printed| lines(&printed));
    if digests()? != pins {
        return Err("the copy without any change does not print tests/golden/digests".into());
    }
    let heads: Vec<_> = pins.iter().map(|(name, _)| format!(" {name:>10}")).collect();
    println!("{:58}{}", "change", heads.concat());
    let (mut noticed, mut tables, mut wrong) = (0, String::new(), Vec::new());
    for control in &CONTROLS {
        let path = copy.join(control.file);
        let original = change(&path, control)?;
        let printed = digests()?;
        std::fs::write(&path, original).map_err(|error| format!("{}: {error}", path.display()))?;
        let changed: Vec<_> = pins.iter().filter(|pin| !printed.contains(pin)).map(|(name, _)| name.as_str()).collect();
        let cell = |(name, _): &(String, String)| {
            format!(" {:>10}", if changed.contains(&name.as_str()) { "changed" } else { "same" })
        };
        println!("{:58}{}", control.what, pins.iter().map(cell).collect::<String>());
        noticed += usize::from(!changed.is_empty());
        if changed.is_empty() {
            wrong.push(format!("{}: no digest changed", control.what));
        }
        if changed.contains(&control.spared) {
            wrong.push(format!("{}: changed {}, which it should not touch", control.what, control.spared));
        }
        tables += &format!("\n[[control]]\nchange = {:?}\nscenes_changed = {changed:?}\n", control.what);
    }
    println!("{noticed} of {} changes are noticed", CONTROLS.len());
    if !wrong.is_empty() {
        return Err(wrong.join("\n"));
    }
    let row = Figure {
        number: "6",
        figure: "digest sensitivity: deliberate changes that change a digest",
        value: &format!("{noticed} of {}", CONTROLS.len()),
        floor: "all of >= 6",
        reached: noticed == CONTROLS.len() && noticed >= 6,
        command: "cargo xtask digests --controls",
    };
    records::write("digest-controls", row.command, &[row.now()?], &tables)
}

/// Makes one change and returns the file as it was.
fn change(path: &Path, control: &Control) -> Result<String, String> {
    let original = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let found = original.matches(control.text).count();
    if found != 1 {
        return Err(format!(
            "\"{}\": {} holds {:?} {found} times instead of once; xtask/src/controls.rs has to follow the source",
            control.what, control.file, control.text
        ));
    }
    std::fs::write(path, original.replace(control.text, control.replacement)).map_err(|error| error.to_string())?;
    Ok(original)
}

/// A copy of the checkout.
fn copied() -> Result<PathBuf, String> {
    let copy = target().join("digests").join("copy");
    let _ = std::fs::remove_dir_all(&copy);
    for name in output("git", &["ls-files", "--cached", "--others", "--exclude-standard"])?.lines() {
        let (from, to) = (top().join(name), copy.join(name));
        let folder = to.parent().unwrap_or(&copy);
        std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        std::fs::copy(&from, &to).map_err(|error| format!("{}: {error}", from.display()))?;
    }
    Ok(copy)
}

#[cfg(test)]
mod tests {
    use super::CONTROLS;

    #[test]
    fn every_change_finds_its_text() {
        for control in &CONTROLS {
            let source = std::fs::read_to_string(crate::tools::top().join(control.file)).expect(control.file);
            assert_eq!(source.matches(control.text).count(), 1, "{}: {}", control.file, control.what);
        }
    }
}
