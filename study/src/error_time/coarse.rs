//! Coarser networks: one node for a block of nodes, in plain scene parameters.

use fabric::Scene;

/// The same sheet with `factor` times the spacing: yarns of `factor` times the area (as many merge into one) and nodes of
/// `factor`^2 times the mass, so that mass, stiffness and strength per width of sheet stay. dt_crit grows by `factor`, cost
/// falls by its cube. What does not stay: the energy to break one yarn grows with its length, and waves shorter than the
/// spacing are lost. The number of segments along a side must be divisible by `factor`.
pub fn coarsened(mut scene: Scene, factor: u32) -> Scene {
    let f = f64::from(factor);
    let sheet = &mut scene.sheet;
    sheet.nodes_x = (sheet.nodes_x - 1) / factor + 1;
    sheet.nodes_y = (sheet.nodes_y - 1) / factor + 1;
    sheet.spacing *= f;
    sheet.yarn_area *= f;
    sheet.node_mass *= f * f;
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn size_and_mass_stay_and_the_step_grows() {
        let mut scene = Scene::sheet_3in_sphere();
        scene.yarn.stochastic = false;
        for factor in [2, 4] {
            let coarse = coarsened(scene, factor);
            assert!((coarse.half_size()[0] / scene.half_size()[0] - 1.0).abs() < 1e-14);
            let ratio = coarse.step_limits().unwrap().dt_crit / scene.step_limits().unwrap().dt_crit;
            assert!((ratio / f64::from(factor) - 1.0).abs() < 1e-14);
            coarse.check().unwrap();
        }
    }
}
