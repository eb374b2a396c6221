use fabric::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let mut scene = Scene::sheet_3in_sphere();
    scene.yarn.stochastic = a[1] == "run";
    if a[1] == "run" { scene.projectile.velocity = [0.0, 0.0, 300.0]; } else {
    scene.projectile.position[2] = -1.0; scene.projectile.velocity = [0.0; 3];
    (scene.track_support, scene.track_detachment) = (false, false); }
    if a[1] == "fabric" { scene.sheet.spacing_y = 1.2 * scene.sheet.spacing; scene.sheet.crimp = [0.001, 0.003]; }
    let layout = Layout::of(&scene).unwrap();
    let mut memory = vec![CacheLine::ZERO; layout.lines()];
    let mut sim = Sim::new(&scene, &mut memory).unwrap();
    sim.use_instructions(if a[3] == "sse2" { InstructionSet::Sse2 } else { InstructionSet::Avx2 }).unwrap();
    sim.step_every_row();
    let mut x = vec![0.0; 3 * layout.nodes()];
    sim.copy_positions(&mut x).unwrap();
    if a[1] != "run" {
        let n = layout.nodes_x;
        let v: Vec<f64> = (0..layout.nodes()).flat_map(|k| { let (i, j) = (k % n, k / n); if i == 0 || j == 0 || i + 1 == n || j + 1 == n { [0.0; 3] } else { [0.0, 0.0, 20.0 * ((i * 7 + j * 3) % 11) as f64 / 11.0] } }).collect();
        sim.set_motion(&x, &v).unwrap();
    }
    sim.advance(100 + a[2].parse::<u64>().unwrap()).unwrap();
}
