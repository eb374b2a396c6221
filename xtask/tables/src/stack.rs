//! Stack that a call into the kernel's C library may need: the frames of the deepest chain of calls from
//! every `fk_*` function.
//!
//! Method: the compiler notes the frame of every function (section `.stack_sizes`); the calls come from the
//! disassembly of the linked library. A frame counts with the return address that the call itself pushes. A
//! function that ends by jumping to another has given up its own frame by then. Functions of the host
//! (memcpy, memset, memmove, memcmp) are not counted.
//! Calls through a pointer are of three kinds, and anything else is an error: functions of the host whose
//! address a register keeps; the formatting of an error's text, whose callees are listed here; and the loops
//! over the kernel's tables of parameters and features, each of which may call every function of the table. A
//! chain that comes back to itself is an error.

use object::{Object, ObjectSection};
use std::collections::BTreeMap;
use std::path::Path;
use xtask::tools::{Context as _, Outcome, bail, ensure, sh, shell};

#[derive(Default)]
struct Function {
    name: String,
    /// Bytes, with the return address.
    frame: u64,
    /// Functions that are called while this one's frame is there.
    calls: Vec<u64>,
    /// Functions that are jumped to at its end.
    jumps: Vec<u64>,
    /// It calls through pointers that are not those of the host's functions.
    pointers: bool,
}

/// The deepest chain of calls from one function.
pub struct Chain {
    pub entry: String,
    /// Stack of the chain, bytes, return addresses included.
    pub bytes: u64,
    /// The functions of the chain from the entry on, with their frames in bytes.
    pub frames: Vec<(String, u64)>,
}

/// Who calls through pointers, and which functions these can be: texts of `core::fmt`, made only for an
/// error.
const POINTERS: [(&str, &[&str]); 5] = [
    ("core::fmt::write", &["<&str as core::fmt::Display>::fmt", "<u64 as core::fmt::Display>::fmt", "write_str"]),
    ("<u64 as core::fmt::Display>::fmt", &["write_str", "write_char"]),
    ("<&str as core::fmt::Display>::fmt", &["write_str", "write_char"]),
    // As the compiler happens to divide it: one function or two.
    ("<core::fmt::Formatter>::pad_integral", &["write_str", "write_char"]),
    ("<core::fmt::Formatter>::pad_integral::write_prefix", &["write_str", "write_char"]),
];

/// Who calls through the tables of parameters and of features: starts of names.
const LOOPS: [&str; 10] = [
    "<fabric_kernel::memory::layout::Layout>::compute",
    "<fabric_kernel::scene::parts::Scene>::check",
    "fabric_kernel::scene::features::",
    "fabric_kernel::scene::fields::lookup::check",
    "fabric_kernel::sim::fingerprint::fingerprint",
    "fabric_capi::sizes::put_scene",
    "fabric_capi::sizes::read_scene",
    "<fabric_kernel::scene::fields::row::Field>::word",
    "<fabric_kernel::scene::fields::row::Field>::set_word",
    "<fabric_capsule::",
];

/// What calls the visitors of the scalar state through pointers, and what is called.
const VISITED: [&str; 2] = ["memory::state::", " as fabric_kernel::memory::state::Visitor>::"];

/// The deepest chain of every exported `fk_*` function, deepest first.
pub fn chains(library: &Path) -> Outcome<Vec<Chain>> {
    let mut functions = disassembled(library)?;
    frames(library, &mut functions)?;
    let named = |wanted: &str| {
        let known =
            functions.iter().filter(move |(_, f)| f.name == wanted || f.name.ends_with(&format!(">::{wanted}")));
        known.map(|(address, _)| *address).collect::<Vec<_>>()
    };
    // What the tables hold: functions of their modules whose address stands in the library's data.
    let held = slots(library)?;
    let of_table = |(address, function): &(&u64, &Function)| {
        ["fields", "features"].iter().any(|table| function.name.contains(&format!("fabric_kernel::scene::{table}::")))
            && held.values().any(|place| place == *address)
    };
    let table: Vec<u64> = functions.iter().filter(of_table).map(|(address, _)| *address).collect();
    let visitors = functions.iter().filter(|(_, function)| function.name.contains(VISITED[1]));
    let visitors: Vec<u64> = visitors.map(|(address, _)| *address).collect();
    let pointers: Vec<(&str, Vec<u64>)> =
        POINTERS.iter().map(|(from, to)| (*from, to.iter().flat_map(|name| named(name)).collect())).collect();
    for function in functions.values_mut().filter(|function| function.pointers) {
        match pointers.iter().find(|(from, _)| *from == function.name) {
            Some((_, to)) => function.calls.extend(to),
            None if LOOPS.iter().any(|start| function.name.starts_with(start)) => function.calls.extend(&table),
            None if function.name.contains(VISITED[0]) => function.calls.extend(&visitors),
            // Start-up code of the linker: no fk_* function calls it, or its frame would be missing.
            None if function.frame == 0 => {}
            None => bail!("{} calls through a pointer: say in stack.rs what it can be", function.name),
        }
    }
    let mut deepest = BTreeMap::new();
    let entries: Vec<u64> = functions
        .iter()
        .filter(|(_, function)| function.name.starts_with("fk_"))
        .map(|(address, _)| *address)
        .collect();
    for &entry in &entries {
        walk(entry, &functions, &mut deepest, &mut Vec::new())?;
    }
    let mut chains = Vec::new();
    for entry in entries {
        let mut frames = Vec::new();
        let mut at = Some(entry);
        while let Some(function) = at.and_then(|address| functions.get(&address)) {
            frames.push((function.name.clone(), function.frame));
            at = at.and_then(|address| deepest.get(&address)).and_then(|(_, next)| *next);
        }
        let bytes = deepest.get(&entry).map_or(0, |(bytes, _)| *bytes);
        chains.push(Chain { entry: functions[&entry].name.clone(), bytes, frames });
    }
    chains.sort_by_key(|chain| std::cmp::Reverse(chain.bytes));
    Ok(chains)
}

/// Finds the stack of a function and what it calls, and which callee needs most.
fn walk(
    at: u64,
    functions: &BTreeMap<u64, Function>,
    deepest: &mut BTreeMap<u64, (u64, Option<u64>)>,
    above: &mut Vec<u64>,
) -> Outcome<u64> {
    if let Some((bytes, _)) = deepest.get(&at) {
        return Ok(*bytes);
    }
    let function = functions.get(&at).with_context(|| format!("a call to {at:x}, where no function is"))?;
    ensure!(!above.contains(&at), "{} calls itself, perhaps through others", function.name);
    ensure!(function.frame > 0, "the frame of {} is not known", function.name);
    above.push(at);
    let mut best = (function.frame, None);
    let calls = function.calls.iter().map(|callee| (function.frame, *callee));
    for (own, callee) in calls.chain(function.jumps.iter().map(|callee| (0, *callee))) {
        let bytes = own + walk(callee, functions, deepest, above)?;
        if bytes > best.0 {
            best = (bytes, Some(callee));
        }
    }
    above.pop();
    deepest.insert(at, best);
    Ok(best.0)
}

/// The functions and their calls, from `objdump` (x86-64).
fn disassembled(library: &Path) -> Outcome<BTreeMap<u64, Function>> {
    let slots = slots(library)?;
    let text = sh!("objdump -d --no-show-raw-insn --demangle=rust {library}").read()?;
    let address = |word: &str| u64::from_str_radix(word, 16).ok();
    let mut functions: BTreeMap<u64, Function> = BTreeMap::new();
    let mut bodies: Vec<(u64, Vec<&str>)> = Vec::new();
    for line in text.lines() {
        if let Some((start, name)) = line.strip_suffix(">:").and_then(|line| line.split_once(" <")) {
            if let Some(start) = address(start) {
                functions.insert(start, Function { name: without_hashes(name), ..Function::default() });
                bodies.push((start, Vec::new()));
            }
        } else if let (Some((_, instruction)), Some((_, body))) = (line.split_once(":\t"), bodies.last_mut()) {
            body.push(instruction.trim());
        }
    }
    for (start, body) in &bodies {
        let mut found = Function::default();
        for (k, instruction) in body.iter().enumerate() {
            let (operation, rest) = instruction.split_once(char::is_whitespace).unwrap_or((instruction, ""));
            let operand = rest.trim();
            let (call, jump) = (operation == "call", operation.starts_with('j'));
            if !call && !jump {
                continue;
            }
            // The library's own functions that it exports are called through a slot of its table.
            let slot = operand.split_once("# ").and_then(|(_, place)| address(place.split_whitespace().next()?));
            if let Some(callee) = slot.and_then(|slot| slots.get(&slot)) {
                if call { &mut found.calls } else { &mut found.jumps }.push(*callee);
            } else if let Some(pointer) = operand.strip_prefix('*') {
                let switch = !call && is_switch(pointer, &body[..k]);
                let of_host =
                    names_host(operand) || from_host(pointer, body) || is_copied_from_host(pointer, &body[..k], body);
                found.pointers |= !switch && !of_host;
            } else if let Some(callee) = operand.split_whitespace().next().and_then(address)
                && functions.contains_key(&callee)
                && (call || callee != *start)
            {
                if call { &mut found.calls } else { &mut found.jumps }.push(callee);
            }
        }
        if let Some(function) = functions.get_mut(start) {
            (function.calls, function.jumps, function.pointers) = (found.calls, found.jumps, found.pointers);
        }
    }
    Ok(functions)
}

/// The places in the library that hold an address of its own once it is loaded, and that address.
fn slots(library: &Path) -> Outcome<BTreeMap<u64, u64>> {
    let text = sh!("readelf --relocs --wide {library}").read()?;
    let relative = text.lines().filter(|line| line.contains("R_X86_64_RELATIVE"));
    let number = |word: Option<&str>| u64::from_str_radix(word?, 16).ok();
    Ok(relative
        .filter_map(|line| {
            let mut words = line.split_whitespace();
            Some((number(words.next())?, number(words.last())?))
        })
        .collect())
}

/// Whether a jump through a register stays in the function, as those of a switch do: its place is taken from
/// a table of distances, or the function's frame, if it has one, is still there.
fn is_switch(register: &str, before: &[&str]) -> bool {
    let from_table = |line: &&str| line.starts_with("movslq (") && line.ends_with(&format!(",{register}"));
    let framed = before.first().is_some_and(|line| line.starts_with("push ") || line.starts_with("sub "));
    let unwinds = |line: &&str| line.starts_with("pop ") || (line.starts_with("add $") && line.ends_with(",%rsp"));
    before.iter().any(from_table) || (framed && !before.iter().rev().take(10).any(unwinds))
}

/// Whether all that this function ever loads into a register from the table of the host's functions is one of
/// these, and there is such a load.
fn from_host(register: &str, body: &[&str]) -> bool {
    let loads: Vec<_> = body
        .iter()
        .filter(|line| line.starts_with("mov ") && line.contains("(%rip)") && line.contains(&format!(",{register} ")))
        .collect();
    !loads.is_empty() && loads.iter().all(|line| names_host(line))
}

/// Whether a register was last written, before a call, with the content of one that [`from_host`] says this
/// of.
fn is_copied_from_host(register: &str, before: &[&str], body: &[&str]) -> bool {
    let last = before.iter().rev().find(|line| line.ends_with(&format!(",{register}")));
    let source = last.and_then(|line| line.strip_prefix("mov ")?.trim().split_once(','));
    source.is_some_and(|(source, _)| source.starts_with('%') && from_host(source, body))
}

/// Whether an instruction names a function of the host.
fn names_host(instruction: &str) -> bool {
    ["<memcpy@", "<memmove@", "<memset@", "<memcmp@"].iter().any(|name| instruction.contains(name))
}

/// A name without the numbers of its crates, like core[c1f1a4ba060b9bfa].
fn without_hashes(name: &str) -> String {
    let is_number = |word: &str| word.len() > 8 && word.bytes().all(|byte| byte.is_ascii_hexdigit());
    let mut parts = name.split('[');
    let first = parts.next().unwrap_or_default().to_string();
    parts.fold(first, |short, part| match part.split_once(']') {
        Some((word, after)) if is_number(word) => short + after,
        _ => short + "[" + part,
    })
}

/// Reads the frames that the compiler noted: for each function its address and its size in seven bits a byte.
fn frames(library: &Path, functions: &mut BTreeMap<u64, Function>) -> Outcome {
    let bytes = shell().read_binary_file(library)?;
    let file = object::File::parse(&*bytes)?;
    let section = file.section_by_name(".stack_sizes").context("the library has no section .stack_sizes")?;
    let mut data = section.data()?;
    while let Some((start, rest)) = data.split_first_chunk::<8>() {
        let (mut size, mut shift) = (0, 0);
        data = rest;
        while let Some((byte, rest)) = data.split_first() {
            size |= u64::from(byte & 0x7f) << shift;
            (data, shift) = (rest, shift + 7);
            if byte & 0x80 == 0 {
                break;
            }
        }
        if let Some(function) = functions.get_mut(&u64::from_le_bytes(*start)) {
            function.frame = size + 8;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn crate_numbers_are_left_out() {
        assert_eq!(super::without_hashes("core[c1f1a4ba060b9bfa]::fmt::write"), "core::fmt::write");
        assert_eq!(super::without_hashes("<[u8; 4]>::len"), "<[u8; 4]>::len");
    }
}
