//! Mistakes of a new user (mistakes.toml): what each gets from the program names the file, the key and the value, and helps.

use std::{fs, path::Path, process::Command};

#[test]
fn the_mistakes_of_a_new_user_get_an_answer_that_helps() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mistakes");
    fs::create_dir_all(&folder).unwrap();
    let table: toml::Table = include_str!("mistakes.toml").parse().unwrap();
    let mistakes = table["mistake"].as_array().unwrap();
    assert!(mistakes.len() >= 30);
    let mut missed = Vec::new();
    let run = |file: &Path, text: &str| {
        fs::write(file, format!("preset = \"sheet_3in_sphere\"\n{text}")).unwrap();
        let mut program = Command::new(env!("CARGO_BIN_EXE_fabric"));
        program.arg("run").arg(file).args(["--steps", "1", "--out"]).arg(folder.join("out")).output().unwrap()
    };
    for (number, mistake) in mistakes.iter().enumerate() {
        let file = folder.join(format!("mistake_{number}.toml"));
        let text = mistake["file"].as_str().unwrap();
        let output = run(&file, text);
        let said = String::from_utf8(output.stderr).unwrap();
        let refused = said.starts_with(&format!("error: {}: ", file.display())) && output.status.code() == Some(2);
        assert!((refused || said.contains("warning: ")) && !said.contains("textile."), "{text}\n{said}");
        if let Some(mended) = mistake.get("mended").and_then(|text| text.as_str())
            && run(&file, mended).status.code() == Some(2)
        {
            missed.push(format!("{text}\n{said}\nis refused where it is followed: {mended}\n"));
        }
        for part in mistake["gets"].as_array().unwrap() {
            if !said.contains(part.as_str().unwrap()) {
                missed.push(format!("{text}\n{said}\nhas not: {part}\n"));
            }
        }
    }
    assert!(missed.is_empty(), "{}", missed.concat());
}
