//! Half-timbered houses for the scene `street`: shops at the bottom, storeys above that jut out and have lit
//! windows, and steep roofs.

use super::festival::{Festival, Spot};
use crate::base::random::Random;
use crate::procedural::modelling::{Shape, dielectric};
use crate::scene::Material;
use glam::Vec3;

/// Adds a house with a random number of storeys at `spot`. In the spot's coordinates, the front of the house is at x = 0,
/// and the house reaches from z = 0 to z = −`width` metres. The upper storeys jut out towards +x, over the street.
pub fn house(street: &mut Festival, random: &mut Random, spot: Spot, width: f32) {
    let plaster = random.pick(&[
        [0.72, 0.62, 0.46],
        [0.68, 0.44, 0.3],
        [0.56, 0.6, 0.53],
        [0.72, 0.68, 0.6],
        [0.62, 0.36, 0.33],
    ]);
    let plaster = Material::lambert("plaster", Vec3::from(plaster));
    let timber = dielectric("timber", Vec3::new(0.11, 0.065, 0.04), 0.6);
    let stone = dielectric("house stone", Vec3::new(0.36, 0.33, 0.29), 0.7);
    let storeys = random.pick(&[1, 2, 2, 3]);
    let (deep, gap) = (7.0, 0.02);
    let mut solid = |material: &Material, a: [f32; 3], b: [f32; 3]| {
        let (a, b) = (Vec3::from(a), Vec3::from(b));
        street
            .model
            .add(material, spot.put(Shape::block(a.min(b), a.max(b))));
    };
    let (near, far) = (-gap, -width + gap);
    solid(&stone, [-deep, -0.2, far], [0.0, 3.05, near]);
    let mut foot = 3.0;
    for storey in 0..storeys {
        let (out, top) = (0.25 * (storey + 1) as f32, foot + 2.7);
        solid(&plaster, [-deep + 0.1, foot + 0.1, far], [out, top, near]);
        // The beams that carry the storey, and the frame of its front.
        solid(
            &timber,
            [-1.0, foot - 0.12, far - 0.005],
            [out + 0.04, foot + 0.12, near + 0.005],
        );
        let posts = (width / 1.35).round() as u32;
        for post in 0..=posts {
            let z = near - 0.1 + (far - near + 0.2) * post as f32 / posts as f32;
            solid(
                &timber,
                [out - 0.1, foot + 0.1, z - 0.09],
                [out + 0.03, top + 0.05, z + 0.09],
            );
        }
        solid(
            &timber,
            [out - 0.1, foot + 0.85, far],
            [out + 0.02, foot + 0.97, near],
        );
        foot = top;
    }
    gable(
        street,
        spot,
        width,
        0.25 * storeys as f32,
        foot,
        &plaster,
        &timber,
    );
    for storey in 0..storeys {
        let out = 0.25 * (storey + 1) as f32;
        windows(street, random, spot, width, out, 3.0 + 2.7 * storey as f32);
    }
    shop(street, random, spot, width, &timber);
}

/// Adds a steep roof with its gable towards the street to a house that is `width` metres wide. `out` is the x coordinate of
/// the front below the gable, and `foot` is the height at which the roof begins, in metres.
fn gable(
    street: &mut Festival,
    spot: Spot,
    width: f32,
    out: f32,
    foot: f32,
    plaster: &Material,
    timber: &Material,
) {
    let (slope, middle) = (1.25, -width / 2.0);
    let high = slope * width / 2.0;
    let wall = Shape::block(
        Vec3::new(-6.8, foot - 0.1, 0.03 - width),
        Vec3::new(out - 0.01, foot + high, -0.03),
    );
    // Narrowed to a ridge of a small width.
    let wall = wall.map(|p| {
        let narrow = if p.y > foot { 0.03 } else { 1.0 };
        Vec3::new(p.x, p.y, middle + (p.z - middle) * narrow)
    });
    street.model.add(plaster, spot.put(wall));
    let tiles = dielectric("tiles", Vec3::new(0.2, 0.07, 0.045), 0.6);
    for side in [-1.0, 1.0] {
        for (material, low, top, over) in [(&tiles, 0.0, 0.16, 0.35), (timber, -0.16, 0.02, 0.28)] {
            let eave = middle + side * (width / 2.0 + over - 0.05);
            let slab = Shape::block(
                Vec3::new(-6.65 - over, low, eave.min(middle)),
                Vec3::new(out + over, top, eave.max(middle)),
            );
            let ridge = foot + high + 0.1;
            let roof = slab.map(|p| p + Vec3::Y * (ridge - slope * (p.z - middle).abs()));
            street.model.add(material, spot.put(roof));
        }
    }
}

/// Adds the windows of one storey; about half of them emit light. `width` is the width of the house, `out` is
/// the x coordinate of the storey's front, and `foot` is the height of the storey's floor, in metres.
fn windows(
    street: &mut Festival,
    random: &mut Random,
    spot: Spot,
    width: f32,
    out: f32,
    foot: f32,
) {
    let frame = dielectric("window frame", Vec3::splat(0.5), 0.5);
    let glass = dielectric("dark window", Vec3::splat(0.02), 0.1);
    let shutter = dielectric(
        "shutter",
        Vec3::from(random.pick(&[[0.05, 0.16, 0.1], [0.3, 0.05, 0.04], [0.06, 0.1, 0.2]])),
        0.5,
    );
    let posts = (width / 1.35).round() as u32;
    for field in 0..posts {
        let z = -width * (field as f32 + 0.5) / posts as f32;
        if random.unit() < 0.2 {
            continue;
        }
        let (low, high, half) = (foot + 1.0, foot + 2.2, 0.36);
        let pane = Shape::quad(
            Vec3::new(out + 0.02, low, z + half),
            -Vec3::Z * 2.0 * half,
            Vec3::Y * (high - low),
        );
        if random.unit() < 0.5 {
            let tint = random.pick(&[[1.3, 0.65, 0.2], [1.2, 0.48, 0.1], [1.2, 0.85, 0.4]]);
            street.light(
                "lit window",
                Vec3::from(tint) * random.pick(&[0.4, 1.0]),
                spot.put(pane),
            );
        } else {
            street.model.add(&glass, spot.put(pane));
        }
        let mut bar = |material: &Material, y: [f32; 2], along: [f32; 2], deep: f32| {
            let shape = Shape::block(
                Vec3::new(out - 0.02, y[0], z + along[0]),
                Vec3::new(out + deep, y[1], z + along[1]),
            );
            street.model.add(material, spot.put(shape));
        };
        bar(
            &frame,
            [low - 0.05, low + 0.03],
            [-half - 0.04, half + 0.04],
            0.07,
        );
        bar(
            &frame,
            [high - 0.03, high + 0.05],
            [-half - 0.04, half + 0.04],
            0.06,
        );
        for edge in [-half, 0.0, half] {
            bar(&frame, [low, high], [edge - 0.025, edge + 0.025], 0.045);
        }
        bar(&frame, [low + 0.75, low + 0.79], [-half, half], 0.04);
        for edge in [-half - 0.15, half + 0.15] {
            bar(
                &shutter,
                [low - 0.02, high + 0.02],
                [edge - 0.1, edge + 0.1],
                0.05,
            );
        }
    }
}

/// Adds a door and a lit shop window to the ground floor of the house at `spot`, which is `width` metres wide. `random`
/// chooses at which end the door is, the colours and the goods in the window. `timber` is the material of the frames.
fn shop(street: &mut Festival, random: &mut Random, spot: Spot, width: f32, timber: &Material) {
    let left = random.unit() < 0.5;
    let at = |t: f32| -width * if left { t } else { 1.0 - t };
    let mut solid = |material: &Material, z: f32, y: [f32; 2], half: f32, x: [f32; 2]| {
        let shape = Shape::block(
            Vec3::new(x[0], y[0], z - half),
            Vec3::new(x[1], y[1], z + half),
        );
        street.model.add(material, spot.put(shape));
    };
    let paint = dielectric(
        "door paint",
        Vec3::from(random.pick(&[[0.2, 0.03, 0.03], [0.03, 0.12, 0.08], [0.16, 0.09, 0.04]])),
        0.4,
    );
    solid(timber, at(0.22), [-0.1, 2.3], 0.62, [-0.1, 0.05]);
    solid(&paint, at(0.22), [-0.1, 2.18], 0.5, [-0.1, 0.065]);
    let half = width * 0.24;
    solid(timber, at(0.67), [0.75, 2.35], half + 0.1, [-0.1, 0.05]);
    for bar in 0..=4 {
        let z = at(0.67) - half + 2.0 * half * bar as f32 / 4.0;
        solid(timber, z, [0.8, 2.3], 0.025, [-0.1, 0.08]);
    }
    solid(timber, at(0.67), [1.74, 1.79], half, [-0.1, 0.075]);
    // The goods are dark in front of the light.
    let wares = dielectric("wares", Vec3::new(0.1, 0.06, 0.04), 0.4);
    let mut z = -half + 0.1;
    while z < half - 0.1 {
        let (wide, high) = (random.between(0.03, 0.08), random.between(0.95, 1.4));
        solid(
            &wares,
            at(0.67) + z + wide,
            [0.85, high],
            wide,
            [-0.1, 0.066],
        );
        z += 2.0 * wide + random.between(0.02, 0.16);
    }
    let tint = Vec3::from(random.pick(&[[1.1, 0.6, 0.2], [1.1, 0.45, 0.1], [0.75, 0.62, 0.36]]));
    for pane in 0..8 {
        let (column, row) = ((pane % 4) as f32, (pane / 4) as f32);
        let corner = Vec3::new(
            0.055,
            0.87 + row * 0.9,
            at(0.67) + half - column * half / 2.0,
        );
        let glass = Shape::quad(corner, -Vec3::Z * half / 2.0, Vec3::Y * (0.9 - 0.44 * row));
        let light = tint * random.pick(&[0.5, 0.75, 1.0]);
        street.light("shop window", light, spot.put(glass));
    }
}
