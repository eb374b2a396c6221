//! Units of numbers in scene files, one rule for the whole file: a number is in SI units; a text has its
//! unit, `"16 g"`; and so has
//! `{ value = 16, unit = "g" }`. A number of an array may be such a text, too.

use crate::{Result, bad, short};
use fabric_kernel::textile::{denier, dtex, per_inch};
use std::f64::consts::PI;
use toml::Value;

/// A unit's name, the SI unit of its kind, and so many of it in that.
type Unit = (&'static str, &'static str, fn(f64) -> f64);

/// The decimal number with its point moved by so many places: "2.778 mm" has the bits of 2.778e-3.
fn moved(x: f64, places: i32) -> f64 {
    if x.is_finite() { format!("{x}e{places}").parse().unwrap_or(f64::NAN) } else { x }
}

/// Grams of force per denier in cN/dtex.
pub const GRAMS_PER_DENIER: f64 = 0.9 * 0.980665;

/// The units beside those of SI. Inch, foot, yard, ounce and grain are those of the international yard and
/// pound, which are exact.
const UNITS: [Unit; 31] = [
    ("mm", "m", |x| moved(x, -3)),
    ("cm", "m", |x| moved(x, -2)),
    ("um", "m", |x| moved(x, -6)),
    ("in", "m", |x| x * 0.0254),
    ("g", "kg", |x| moved(x, -3)),
    ("mg", "kg", |x| moved(x, -6)),
    ("grain", "kg", |x| x * 64.79891e-6),
    ("km/s", "m/s", |x| moved(x, 3)),
    ("ft/s", "m/s", |x| x * 0.3048),
    ("deg", "rad", |x| x * PI / 180.0),
    ("deg/s", "rad/s", |x| x * PI / 180.0),
    ("rpm", "rad/s", |x| x * PI / 30.0),
    ("ms", "s", |x| moved(x, -3)),
    ("us", "s", |x| moved(x, -6)),
    ("ns", "s", |x| moved(x, -9)),
    ("kN", "N", |x| x * 1e3),
    ("MPa", "Pa", |x| x * 1e6),
    ("GPa", "Pa", |x| x * 1e9),
    ("1/GPa", "1/Pa", |x| moved(x, -9)),
    ("g/cm3", "kg/m3", |x| x * 1e3),
    ("denier", "kg/m", denier),
    ("dtex", "kg/m", dtex),
    ("tex", "kg/m", |x| moved(x, -6)),
    ("1/in", "1/m", per_inch),
    ("1/cm", "1/m", |x| x * 100.0),
    ("1/10cm", "1/m", |x| x * 10.0),
    ("g/m2", "kg/m2", |x| moved(x, -3)),
    ("oz/yd2", "kg/m2", |x| x * 28.349523125e-3 / (0.9144 * 0.9144)),
    ("%", "1", |x| x / 100.0),
    ("mm2", "m2", |x| moved(x, -6)),
    ("g.mm2", "kg.m2", |x| moved(x, -9)),
];

/// Other spellings of units.
#[rustfmt::skip]
const SPELLINGS: [(&str, &str); 9] = [
    ("grains", "grain"), ("gr", "grain"), ("fps", "ft/s"), ("inch", "in"), ("inches", "in"), ("1/inch", "1/in"), ("ypi", "1/in"),
    ("den", "denier"), ("g/denier", "g/den"),
];

/// What a count counts.
const COUNTED: [&str; 4] = ["ends", "picks", "yarns", "threads"];

/// A unit as [`UNITS`] spells it: "ends/10 cm" is "1/10cm", and "cm³" is "cm3".
fn spelled(unit: &str) -> String {
    let mut unit = unit.replace([' ', '^'], "").replace('²', "2").replace('³', "3").replace(['µ', 'μ'], "u");
    unit = unit.replace('°', "deg");
    let per = COUNTED.iter().chain(&[""]).find_map(|what| unit.strip_prefix(what)?.strip_prefix('/'));
    if let Some(per) = per {
        unit = format!("1/{per}");
    }
    SPELLINGS.iter().find(|(other, _)| *other == unit).map_or(unit, |(_, own)| own.to_string())
}

/// Keys of a number that is a table.
const PARTS: [&str; 4] = ["value", "unit", "source", "mark"];

/// A number without unit.
pub fn plain(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

/// Number and unit of a text or a table `{ value, unit }`, the unit as [`UNITS`] spells it.
pub fn with_unit(value: &Value) -> Option<(f64, String)> {
    let (number, unit) = match value {
        Value::Table(table) if table.keys().all(|key| PARTS.contains(&&**key)) => {
            (plain(table.get("value")?)?, table.get("unit")?.as_str()?)
        }
        // No number is longer.
        Value::String(text) if text.len() <= 80 => {
            let number = |end: usize| Some((text.get(..end)?.parse().ok()?, text.get(end..)?));
            (1..=text.len()).rev().find_map(number)?
        }
        _ => return None,
    };
    Some((number, spelled(unit)))
}

/// A number in SI units, whose unit is `si`; none if it is no number of this kind.
pub fn number(value: &Value, si: &str) -> Option<f64> {
    if let Some(number) = plain(value) {
        return Some(number);
    }
    let (number, unit) = with_unit(value)?;
    let known = UNITS.iter().find(|(name, kind, _)| *name == unit && *kind == si);
    known.map(|(.., in_si)| in_si(number)).or_else(|| (unit == si).then_some(number))
}

/// The units of a kind beside that of SI.
fn of_kind(si: &str) -> Vec<&'static str> {
    UNITS.iter().filter(|(_, kind, _)| *kind == si).map(|(name, ..)| *name).collect()
}

/// Ways to write a number so that it fits: as it is, in SI units, or with the units of its kind that make a
/// value which `fits`.
pub fn likely(number: f64, si: &str, fits: &dyn Fn(f64) -> bool) -> Vec<String> {
    if number.is_finite() && fits(number) {
        return vec![format!("{number} without quotes")];
    }
    let quoted = |unit| format!("\"{number} {unit}\"");
    let known = of_kind(si).into_iter().map(quoted);
    known.filter(|text| self::number(&text.trim_matches('"').into(), si).is_some_and(fits)).collect()
}

/// What somebody meant who wrote this of a number that `fits`: a decimal comma, a unit in other letters, or
/// none.
pub fn meant(value: &Value, si: &str, fits: &dyn Fn(f64) -> bool) -> String {
    match value {
        Value::Array(all) => {
            return all.iter().find(|one| number(one, si).is_none()).map_or(String::new(), |one| meant(one, si, fits));
        }
        Value::Table(table) => {
            let other = table.keys().find(|key| !PARTS.contains(&&***key));
            return other
                .map_or(String::new(), |key| format!("; a number has {}, and no `{}`", PARTS.join(", "), short(key)));
        }
        _ => {}
    }
    let text = value.as_str().unwrap_or_default();
    // "1,000" is a thousand; "5,556" may be thousands or have a decimal comma.
    let (first, rest) = text
        .split(|c: char| !c.is_ascii_digit() && !",.".contains(c))
        .next()
        .unwrap_or("")
        .split_once(',')
        .unwrap_or_default();
    let grouped = (1..4).contains(&first.len())
        && first != "0"
        && rest.split('.').take(1).flat_map(|whole| whole.split(',')).all(|part| part.len() == 3);
    let decimal = !grouped || rest != "000" && !rest.contains([',', '.']);
    let readings = [grouped.then(|| text.replace(',', "")), decimal.then(|| text.replacen(',', ".", 1))];
    let hints_of = |(number, unit): (f64, String)| {
        let unit = unit.replace("cc", "cm3");
        let mut names = of_kind(si).into_iter().chain([si]);
        match names.find(|name| name.eq_ignore_ascii_case(&unit)) {
            Some(name) => vec![format!("\"{number} {name}\"")],
            None if unit.is_empty() => likely(number, si, fits),
            None => Vec::new(),
        }
    };
    let numbers = readings.into_iter().flatten().filter_map(|text| with_unit(&text.into()));
    let hints: Vec<String> = numbers.flat_map(hints_of).collect();
    if hints.is_empty() { String::new() } else { format!("; write {}", hints.join(" or ")) }
}

/// The refusal of what is no number of this kind; `also`: other units that its key takes.
pub fn refused<T>(key: &str, value: &Value, si: &str, also: &str, fits: &dyn Fn(f64) -> bool) -> Result<T> {
    let (expected, meant) = (expected(si), meant(value, si, fits));
    bad(key, format!("{key} = {}: must be a number{expected}{also}{meant}", short(&value.to_string())))
}

/// What a number of this kind must be, in words: after "a number" or "an array of 3 numbers".
pub fn expected(si: &str) -> String {
    let names = of_kind(si);
    match (si, names.first()) {
        (_, None) => format!(", in {si}"),
        ("1", _) => ", or with %, as in \"5 %\"".to_string(),
        (_, Some(first)) => format!(", in {si}, or with its unit, as in \"5 {first}\" ({si}, {})", names.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_way_to_write_a_unit_gives_the_number_in_si_units() {
        let of = |text: &str, si: &str| number(&Value::from(text), si).unwrap_or_else(|| panic!("{text}"));
        const GRAIN: f64 = 64.79891e-6;
        #[rustfmt::skip]
        let ways = [
            ("16 g", "kg", 16e-3), ("3 mg", "kg", 3e-6), ("17 grain", "kg", 17.0 * GRAIN), ("17 grains", "kg", 17.0 * GRAIN),
            ("17 gr", "kg", 17.0 * GRAIN), ("5.56mm", "m", 5.56e-3), ("-3 mm", "m", -3e-3), ("2 cm", "m", 0.02),
            ("1e3 um", "m", 1e-3), ("0.22 in", "m", 0.22 * 0.0254), ("2 inches", "m", 2.0 * 0.0254), ("1 inch", "m", 0.0254),
            ("inf mm", "m", f64::INFINITY), ("1.2 km/s", "m/s", 1200.0), ("500 ft/s", "m/s", 500.0 * 0.3048),
            ("500 fps", "m/s", 500.0 * 0.3048), ("30 deg", "rad", PI / 6.0), ("30°", "rad", PI / 6.0),
            ("180 deg/s", "rad/s", PI), ("30 rpm", "rad/s", 30.0 * PI / 30.0), ("2 ms", "s", 2e-3), ("20 µs", "s", 20e-6),
            ("7 ns", "s", 7e-9), ("2 kN", "N", 2e3), ("3 MPa", "Pa", 3e6), ("85 GPa", "Pa", 85e9), ("4 1/GPa", "1/Pa", 4e-9),
            ("7.85 g/cm³", "kg/m3", 7850.0), ("600 denier", "kg/m", 600.0 * 1e-3 / 9000.0), ("600 den", "kg/m", 600.0 * 1e-3 / 9000.0),
            ("930 dtex", "kg/m", 930.0 * 1e-3 / 1e4), ("93 tex", "kg/m", 93e-6), ("34 /cm", "1/m", 3400.0), ("34 1/cm", "1/m", 3400.0),
            ("12 ends/cm", "1/m", 1200.0), ("120 picks / 10 cm", "1/m", 1200.0), ("34 yarns/inch", "1/m", 34.0 / 0.0254),
            ("34 ypi", "1/m", 34.0 / 0.0254), ("34 1/in", "1/m", 34.0 / 0.0254), ("180 g/m²", "kg/m2", 0.18),
            ("8 oz/yd²", "kg/m2", 8.0 * 28.349523125e-3 / (0.9144 * 0.9144)), ("1.5 %", "1", 0.015), ("3 mm²", "m2", 3e-6),
            ("5 g.mm2", "kg.m2", 5e-9),
        ];
        for (text, si, expected) in ways {
            assert_eq!(of(text, si).to_bits(), expected.to_bits(), "{text}");
        }
        for (unit, ..) in UNITS {
            let tried =
                |(text, ..): &(&str, &str, f64)| with_unit(&Value::from(*text)).is_some_and(|(_, of)| of == unit);
            assert!(ways.iter().any(tried), "{unit}");
        }
        for (text, si) in [("16", "kg"), ("16 mm", "kg"), ("mm", "m"), ("", "m"), ("5,56 mm", "m"), ("sixteen g", "kg")]
        {
            assert_eq!(number(&Value::from(text), si), None, "{text}");
        }
        let table: toml::Table = "x = { value = 16, unit = \"g\" }".parse().unwrap();
        assert_eq!(number(&table["x"], "kg"), Some(0.016));
    }

    /// What may be shown by another program may be written here.
    #[test]
    fn every_display_unit_of_the_table_of_parameters_is_known() {
        for quantity in fabric_kernel::fields::FIELDS.iter().filter_map(|field| field.quantity) {
            let known = UNITS.iter().any(|(name, si, _)| (*name, *si) == (quantity.display, quantity.unit));
            assert!(quantity.display.is_empty() || known, "{}", quantity.display);
        }
    }
}
