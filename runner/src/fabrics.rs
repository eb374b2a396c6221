//! `fabric fabrics`: the named textiles.

use crate::{Result, report, say};
use fabric_scene::textile;

/// A line for each named textile, or the file of one.
pub fn print(name: Option<&str>) -> Result<bool> {
    let all = textile::all()?;
    if let Some(name) = name {
        let names: Vec<_> = all.iter().map(|named| named.name).collect();
        let found = all.iter().find(|named| named.name == name);
        let found = found.ok_or_else(|| format!("no fabric {name}: one of {}", names.join(", ")))?;
        say::text(format_args!("{}", found.file));
        return Ok(true);
    }
    let mut rows = Vec::new();
    for textile::Named { name, title, textile, .. } in all {
        let woven = textile.warp.count > 0.0;
        let shown = |number: f64, digits: usize| {
            if number.is_finite() && woven { format!("{number:.digits$}") } else { "-".to_string() }
        };
        rows.push(vec![
            name.to_string(),
            shown(1e3 * textile.areal_density(), 1),
            shown(1e3 / textile.weft.count, 4),
            shown(1e6 * textile.warp.linear_density / textile.fibre_density, 5),
            format!("{:.0}", textile.wave_speed()),
            format!("{:.5}", textile.critical_stretch()?),
            title,
        ]);
    }
    let heading = ["name", "g/m2", "spacing mm", "area mm2", "wave m/s", "U_c", "title"];
    say::line(format_args!("{}\n\nsources: fabric fabrics NAME", report::table(&heading, &rows)));
    Ok(true)
}
