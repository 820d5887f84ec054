//! Random settings of camera, projector and matcher, so that a network does not learn one sensor by heart.

use super::Random;
use crate::sim::scene::Scene;

/// Draws imager, projector and matcher settings for the scene's seed.
pub fn vary_sensor(scene: &mut Scene) {
    let mut random = Random::new(scene.seed ^ 0x73656e73);
    let imager = &mut scene.imager;
    imager.projector = random.about(imager.projector, 0.3);
    imager.speckle_px = random.within(2.0, 4.0);
    imager.speckle_contrast = random.within(0.7, 1.0);
    imager.exposure_mean = random.within(0.22, 0.38);
    imager.exposure_bias = random.within(0.8, 1.25);
    imager.electrons = random.within(3000.0, 9000.0);
    imager.read_noise = random.within(0.6, 1.5);
    let matcher = &mut scene.matcher;
    matcher.uniqueness = random.within(0.01, 0.07);
    matcher.left_right_px = random.within(0.6, 2.0);
    matcher.texture = random.within(0.4, 1.6);
    matcher.largest_cost = random.within(0.33, 0.42);
    matcher.step_px = random.pick(&[1.0 / 64.0, 1.0 / 32.0, 1.0 / 16.0]);
}
