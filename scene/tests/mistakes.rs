//! Thirty mistakes of a new user, and what each gets: the file's name, the key, the value, and what helps.

use fabric_scene::memory::Buffers;
use fabric_scene::{notes, read};

/// Each with parts of its answer; a line that begins with a table goes below `preset`.
const MISTAKES: [(&str, &[&str]); 34] = [
    // Units.
    ("[projectile]\nradius = 2.778", &["projectile.radius: ", "reaches 2.778 m", "write \"2.778 mm\""]),
    (
        "[projectile]\nradius = \"2.778 g\"",
        &["projectile.radius = \"2.778 g\": must be a number, in m", "(m, mm, cm, um, in)"],
    ),
    ("[projectile]\nradius = \"2,778 mm\"", &["projectile.radius = \"2,778 mm\"", "as in \"5 mm\""]),
    ("[projectile]\nradius = \"2.778\"", &["projectile.radius = \"2.778\"", "with its unit, as in \"5 mm\""]),
    ("[projectile]\nmass = 0.69", &["note: a projectile of 0.69 kg", "too heavy", "643.338 g/cm3"]),
    ("[projectile]\nmass = \"0.69 stones\"", &["projectile.mass = \"0.69 stones\"", "(kg, g, mg, grain)"]),
    ("[projectile]\nmass = \"8 mg\"", &["note: a projectile of 0.000008 kg", "too light", "0.007 g/cm3"]),
    ("[sheet]\nwidth = 102", &["sheet.width = 102: ", "140552 nodes", "2 to 65535"]),
    ("[sheet]\nnodes_x = \"102 mm\"", &["sheet.nodes_x = \"102 mm\": must be a whole number"]),
    (
        "[fabric]\nname = \"kevlar_km2_s706\"\ncount = 34",
        &["fabric.warp.count = 3.4e1 1/m", "write the unit, as in \"34 1/in\""],
    ),
    ("[fabric]\nname = \"kevlar_km2_s706\"\nmodulus = 84.6", &["fabric.modulus = 8.46e1 Pa", "\"84.6 GPa\""]),
    ("[fabric]\nname = \"kevlar_km2_s706\"\ncount = \"34 /ft\"", &["fabric.count = \"34 /ft\"", "1/in, 1/cm"]),
    ("[aim]\nangle = 30", &["aim.angle = 30: must be from 0 to below 90 deg", "in rad"]),
    ("[aim]\nangle = \"90 deg\"", &["aim.angle = 1.57", "below 90 deg"]),
    ("[aim]\npoint = [10, 0]", &["aim.point: (10, 0) m lies beside the sheet"]),
    // Names.
    ("[projektile]\nmass = \"16 g\"", &["unknown key `projektile`; is it `projectile`?"]),
    ("[projectile]\nweight = \"16 g\"", &["unknown key `projectile.weight`; is it `projectile.mass`?"]),
    ("[projectile]\ncaliber = \"5.56 mm\"", &["unknown key `projectile.caliber`; is it `projectile.diameter`?"]),
    ("[sheet]\nwidht = \"102 mm\"", &["unknown key `sheet.widht`; is it `sheet.width`?"]),
    ("[contact]\nfricton = 0.2", &["unknown key `contact.fricton`; is it `contact.friction`?"]),
    ("fabrik = \"kevlar_km2_s706\"", &["unknown key `fabrik`; is it `fabric`?"]),
    ("fabric = \"kevlar\"", &["fabric.name = \"kevlar\": must be one of \"kevlar_km2_s706\""]),
    (
        "[projectile]\nmaterial = \"iron\"",
        &["projectile.material = \"iron\": one of \"steel\"", "give projectile.density"],
    ),
    ("[projectile]\nshape = \"ball\"", &["projectile.shape = \"ball\": must be one of \"sphere\""]),
    ("[projectile]\nvelocity = 150", &["projectile.velocity = 150: must be an array of 3 numbers"]),
    // Sense.
    ("[projectile]\nmass = -1", &["NotPositive projectile.mass", "-1"]),
    ("[projectile]\ndensity = \"-7.85 g/cm3\"", &["projectile.density = -7850: must be greater than 0"]),
    ("[projectile]\nvelocity = [0, 0, -150]", &["projectile.velocity = [0, 0, -150]: never leads", "give [aim]"]),
    ("[projectile]\nposition = [0, 0, 0.01]", &["projectile.position = [0, 0, 0.01]"]),
    ("[projectile]\nlength = \"10 mm\"", &["projectile.length: this scene does not read it"]),
    // Both of two.
    ("[sheet]\nwidth = \"102 mm\"\nnodes_x = 136", &["sheet.width and sheet.nodes_x: one follows from the other"]),
    ("[projectile]\nmaterial = \"steel\"\nmass = \"0.69 g\"", &["projectile.material and projectile.mass"]),
    ("[aim]\nspeed = \"150 m/s\"\n[projectile]\nvelocity = [0, 0, 150]", &["aim.speed and projectile.velocity"]),
    (
        "[projectile]\nweight = 1\ndiameter = \"5 mm\"\nradius = 2e-3\n[sheet]\nwith = 1",
        &["projectile.diameter and projectile.radius", "`projectile.weight`", "`sheet.with`; is it `sheet.width`?"],
    ),
];

/// What a file gets: a refusal of the reader or of the kernel, or a note.
fn answer(path: &std::path::Path) -> String {
    let scene = match read(path) {
        Err(error) => return error.to_string(),
        Ok(scene) => scene,
    };
    let refused = Buffers::check(&scene).err().map(|error| match error.downcast_ref::<fabric::Error>() {
        Some(error) => format!("{:?} {}: {}", error.code, error.field, error.value),
        None => error.to_string(),
    });
    let note = notes::unlikely_body(&scene).map(|note| format!("note: {note}"));
    refused.or(note).unwrap_or_else(|| "nothing".to_string())
}

#[test]
fn thirty_mistakes_of_a_new_user_get_an_answer_that_helps() {
    let folder = std::env::temp_dir().join(format!("fabric_mistakes_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    for (number, (text, parts)) in MISTAKES.iter().enumerate() {
        let path = folder.join(format!("mistake_{number}.toml"));
        std::fs::write(&path, format!("preset = \"sheet_3in_sphere\"\n{text}\n")).unwrap();
        let answer = answer(&path);
        println!("{text}\n    {answer}\n");
        for part in *parts {
            assert!(answer.contains(part), "{text}\n{answer}\nhas not: {part}");
        }
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
