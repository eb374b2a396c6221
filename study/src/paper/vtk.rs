//! A run as a series that ParaView opens: run.pvd lists for each time the sheet and the projectile as VTK PolyData.
//!
//! The sheet: positions (m), one line a segment with its alpha and stretch as cell data; failed segments are kept, so that the
//! cells are the same at all times (hide them with a threshold on alpha; their stretch is a mere distance of two nodes). The projectile: a mesh of its surface.
//! Reference: VTK file formats, XML, inline binary data (a count of bytes and the little-endian data, in base64).

use super::plan::{self, Effort, Yarn};
use crate::memory::Buffers;
use crate::progress::Progress;
use crate::{Result, event, run};
use base64::Engine;
use fabric::{AttachmentKind, Outcome, Scene, Shape, Sim};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};
use std::path::{Path, PathBuf};

/// Impact energy of the run, J.
const ENERGY: f64 = 40.0;
/// Time between two frames, s.
const PAUSE: f64 = 10e-6;
/// Most frames.
const FRAMES: usize = 80;

/// Numbers of a data array.
enum Data<'a> {
    Float32(&'a [f32]),
    Int32(&'a [i32]),
}

impl Data<'_> {
    fn type_name(&self) -> &'static str {
        match self {
            Data::Float32(_) => "Float32",
            Data::Int32(_) => "Int32",
        }
    }

    /// Count of bytes and data, in base64.
    fn text(&self) -> String {
        let values: Vec<u8> = match self {
            Data::Float32(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Data::Int32(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        };
        let mut bytes = (values.len() as u32).to_le_bytes().to_vec();
        bytes.extend(values);
        base64::engine::general_purpose::STANDARD.encode(bytes)
    }
}

/// Points, cells of one kind, and numbers for each cell.
struct PolyData<'a> {
    points: &'a [f32],
    /// "Lines" or "Polys".
    kind: &'static str,
    /// Nodes of all cells one after another, and where each cell ends among them.
    connectivity: &'a [i32],
    offsets: &'a [i32],
    cell_data: &'a [(&'static str, &'a [f32])],
}

type Xml = Writer<Vec<u8>>;

fn array(xml: &mut Xml, name: &str, components: &str, data: &Data<'_>) -> std::io::Result<()> {
    xml.create_element("DataArray")
        .with_attributes([
            ("type", data.type_name()),
            ("Name", name),
            ("NumberOfComponents", components),
            ("format", "binary"),
        ])
        .write_text_content(BytesText::new(&data.text()))?;
    Ok(())
}

fn file(kind: &str, content: impl FnOnce(&mut Xml) -> std::io::Result<()>) -> Result<Vec<u8>> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 1);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", None, None)))?;
    xml.create_element("VTKFile")
        .with_attributes([
            ("type", kind),
            ("version", "1.0"),
            ("byte_order", "LittleEndian"),
            ("header_type", "UInt32"),
        ])
        .write_inner_content(content)?;
    Ok(xml.into_inner())
}

impl PolyData<'_> {
    fn write(&self, path: &Path) -> Result<()> {
        let points = (self.points.len() / 3).to_string();
        let cells = self.offsets.len().to_string();
        let count = if self.kind == "Lines" { "NumberOfLines" } else { "NumberOfPolys" };
        let bytes = file("PolyData", |xml| {
            let piece = |xml: &mut Xml| {
                let piece = xml.create_element("Piece");
                let piece = piece.with_attributes([("NumberOfPoints", points.as_str()), (count, cells.as_str())]);
                piece.write_inner_content(|xml| {
                    xml.create_element("CellData").write_inner_content(|xml| {
                        self.cell_data
                            .iter()
                            .try_for_each(|(name, values)| array(xml, name, "1", &Data::Float32(values)))
                    })?;
                    xml.create_element("Points")
                        .write_inner_content(|xml| array(xml, "Points", "3", &Data::Float32(self.points)))?;
                    xml.create_element(self.kind).write_inner_content(|xml| {
                        array(xml, "connectivity", "1", &Data::Int32(self.connectivity))?;
                        array(xml, "offsets", "1", &Data::Int32(self.offsets))
                    })?;
                    Ok(())
                })?;
                Ok(())
            };
            xml.create_element("PolyData").write_inner_content(piece)?;
            Ok(())
        })?;
        std::fs::write(path, bytes).map_err(|error| format!("{}: {error}", path.display()).into())
    }
}

/// Runs the preset 3 in sheet held at its corners and writes the series to `out`/vtk. Returns the .pvd file.
pub fn series(out: &Path, effort: Effort) -> Result<PathBuf> {
    let folder = out.join("vtk");
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let scene = plan::small(effort, AttachmentKind::FourCorners, Yarn::Stochastic, ENERGY).scene(effort, 0);
    let mut buffers = Buffers::of(&scene)?;
    let mut sim = buffers.sim(&scene)?;
    let mask = event::mask_of(&[Outcome::Arrested, Outcome::Exited]);
    let steps = (PAUSE / sim.step_limits().dt).round().max(1.0) as u64;
    let (connectivity, offsets) = lines(&sim);
    let progress = Progress::new("VTK series, of the most frames", FRAMES as u64);
    let mut entries = Vec::new();
    for frame in 0..FRAMES {
        let names = [format!("sheet_{frame:04}.vtp"), format!("projectile_{frame:04}.vtp")];
        write_sheet(&folder.join(&names[0]), &sim, &connectivity, &offsets)?;
        write_projectile(&folder.join(&names[1]), &scene, &sim)?;
        entries.extend(names.into_iter().enumerate().map(|(part, name)| (sim.time(), part, name)));
        progress.add(1, || format!("{:.0} us", 1e6 * sim.time()));
        if sim.outcomes().mask & mask != 0 {
            break;
        }
        sim.advance_until(mask, steps).map_err(|failure| failure.to_string())?;
    }
    progress.finish();
    let bytes = file("Collection", |xml| {
        xml.create_element("Collection").write_inner_content(|xml| {
            entries.iter().try_for_each(|(time, part, name)| {
                let (time, part) = (format!("{time:e}"), part.to_string());
                let set = xml.create_element("DataSet");
                let set = set.with_attributes([
                    ("timestep", time.as_str()),
                    ("part", part.as_str()),
                    ("file", name.as_str()),
                ]);
                set.write_empty().map(|_| ())
            })
        })?;
        Ok(())
    })?;
    let path = folder.join("run.pvd");
    std::fs::write(&path, bytes)?;
    Ok(path)
}

/// Nodes of every segment in the order of their numbers, and where each ends.
fn lines(sim: &Sim<'_>) -> (Vec<i32>, Vec<i32>) {
    let (nx, ny) = (sim.layout().nodes_x as i32, sim.layout().nodes_y as i32);
    let across = (0..ny).flat_map(|j| (0..nx - 1).map(move |i| [j * nx + i, j * nx + i + 1]));
    let along = (0..ny - 1).flat_map(|j| (0..nx).map(move |i| [j * nx + i, (j + 1) * nx + i]));
    let connectivity: Vec<i32> = across.chain(along).flatten().collect();
    let offsets = (1..=connectivity.len() as i32 / 2).map(|k| 2 * k).collect();
    (connectivity, offsets)
}

fn write_sheet(path: &Path, sim: &Sim<'_>, connectivity: &[i32], offsets: &[i32]) -> Result<()> {
    let (nodes, segments) = (sim.layout().nodes(), sim.layout().segments());
    let (mut positions, mut alpha, mut stretch) = (vec![0.0; 3 * nodes], vec![0.0; segments], vec![0.0; segments]);
    sim.copy_positions(&mut positions)?;
    sim.copy_damage(&mut alpha)?;
    sim.copy_stretch(&mut stretch)?;
    let single = |values: &[f64]| values.iter().map(|&value| value as f32).collect::<Vec<f32>>();
    let cell_data = [("alpha", single(&alpha)), ("stretch", single(&stretch))];
    PolyData {
        points: &single(&positions),
        kind: "Lines",
        connectivity,
        offsets,
        cell_data: &[(cell_data[0].0, &cell_data[0].1), (cell_data[1].0, &cell_data[1].1)],
    }
    .write(path)
}

/// The surface as quadrilaterals between rings about the body's z axis.
fn write_projectile(path: &Path, scene: &Scene, sim: &Sim<'_>) -> Result<()> {
    const AROUND: i32 = 32;
    let (radius, half) = (scene.projectile.radius, 0.5 * scene.projectile.length);
    // Rings as (radius, height), from pole to pole.
    let rings: Vec<(f64, f64)> = match scene.projectile.shape {
        Shape::Sphere => {
            let angles = (0..=16).map(|k| std::f64::consts::PI * k as f64 / 16.0);
            angles.map(|angle| (radius * angle.sin(), -radius * angle.cos())).collect()
        }
        _ => vec![(0.0, -half), (radius, -half), (radius, half), (0.0, half)],
    };
    let motion = sim.projectile()?;
    let mut points = Vec::new();
    for (ring_radius, height) in &rings {
        for k in 0..AROUND {
            let angle = std::f64::consts::TAU * k as f64 / AROUND as f64;
            let x = run::placed([ring_radius * angle.cos(), ring_radius * angle.sin(), *height], &motion);
            points.extend(x.map(|x| x as f32));
        }
    }
    let mut connectivity = Vec::new();
    for ring in 0..rings.len() as i32 - 1 {
        for k in 0..AROUND {
            let (a, b) = (ring * AROUND + k, ring * AROUND + (k + 1) % AROUND);
            connectivity.extend([a, b, b + AROUND, a + AROUND]);
        }
    }
    let offsets: Vec<i32> = (1..=connectivity.len() as i32 / 4).map(|k| 4 * k).collect();
    PolyData { points: &points, kind: "Polys", connectivity: &connectivity, offsets: &offsets, cell_data: &[] }
        .write(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_begin_with_their_length() {
        // 4 bytes: 04 00 00 00, then 1.0f32 = 00 00 80 3f.
        assert_eq!(Data::Float32(&[1.0]).text(), "BAAAAAAAgD8=");
        assert_eq!(Data::Int32(&[]).text(), "AAAAAA==");
    }
}
