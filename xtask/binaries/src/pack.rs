//! Archives (ZIP).

use std::fs;
use std::io::Write as _;
use xtask::tools::Outcome;

/// Packs files so that the same files give the same bytes: sorted, with one fixed time and mode.
/// An entry is `NAME=FILE`.
pub fn pack(archive: &str, entries: &[&str]) -> Outcome {
    let split = |entry: &&str| entry.split_once('=').map(|(name, file)| (name.to_string(), file.to_string()));
    let mut entries: Vec<_> = entries.iter().filter_map(split).collect();
    entries.sort();
    let file = fs::File::create(archive).map_err(|error| format!("{archive}: {error}"))?;
    let mut zip = zip::ZipWriter::new(file);
    for (name, path) in entries {
        let bytes = fs::read(&path).map_err(|error| format!("{path}: {error}"))?;
        let mode = if name.starts_with("binaries/") { 0o755 } else { 0o644 };
        let options = zip::write::SimpleFileOptions::default()
            .compression_method(zip::CompressionMethod::Deflated)
            .compression_level(Some(9))
            .last_modified_time(zip::DateTime::default())
            .unix_permissions(mode);
        zip.start_file(&name, options).map_err(|error| format!("{name}: {error}"))?;
        zip.write_all(&bytes).map_err(|error| format!("{name}: {error}"))?;
    }
    zip.finish().map_err(|error| format!("{archive}: {error}"))?;
    Ok(())
}
