//! Furniture for the scene `two-rooms`. Each piece stands on the floor at the origin, with its front towards
//! +Z. Lengths are in metres.

use crate::base::random::Random;
use crate::procedural::modelling::{Builder, Model, Shape, dielectric, lathe, metal, soft_box};
use crate::scene::Material;
use glam::{DAffine3, DQuat, Vec3};

/// A piece of furniture that is placed as a whole with [`Self::put`]. All its flat shapes become one mesh
/// without normals, with one part for each material. Its smooth shapes become one mesh for each material.
#[derive(Default)]
pub struct Piece {
    flat: Model,
    smooth: Model,
}

impl Piece {
    /// Adds a shape without normals, which is shaded flat, to the piece. All flat shapes of the piece become
    /// one mesh.
    pub fn flat(&mut self, material: &Material, shape: Shape) {
        self.flat.add(material, shape);
    }

    /// Adds a shape that has smooth normals to the piece. The smooth shapes of equal materials are merged into one mesh.
    pub fn smooth(&mut self, material: &Material, shape: Shape) {
        self.smooth.add(material, shape);
    }

    /// Adds the piece to a scene. It stands at the position `at` in metres, rotated by `degrees` around its vertical axis.
    /// The instance of the flat shapes gets the name `name`. Each mesh of smooth shapes gets an instance of its own, whose
    /// name is `name`, a colon, and the name of the material.
    pub fn put(self, scene: &mut Builder, name: &str, at: Vec3, degrees: f64) {
        let turn = DQuat::from_rotation_y(degrees.to_radians());
        let transform = DAffine3::from_rotation_translation(turn, at.as_dvec3());
        if !self.flat.0.is_empty() {
            scene.add_model(name, self.flat);
            if let Some(instance) = scene.0.instances.last_mut() {
                instance.object_to_world = transform;
            }
        }
        for (material, shape) in self.smooth.0 {
            let part = format!("{name}: {}", material.name);
            let mesh = scene.mesh(material, shape);
            scene.place(&part, mesh, transform);
        }
    }
}

/// Four upright square legs of a piece of furniture, at the corners of a rectangle around the origin.
/// `half.x` and `half.z` are half the lengths of the rectangle's sides along X and Z; `half.y` is not used.
/// All lengths are in metres.
fn legs(half: Vec3, height: f32, thickness: f32) -> Shape {
    let mut legs = Shape::default();
    for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        let middle = Vec3::new(x * half.x, height / 2.0, z * half.z);
        legs.add(Shape::chunk(
            middle,
            Vec3::new(thickness, height, thickness),
        ));
    }
    legs
}

/// A chair of the material `wood`, 0.95 m high, whose back has three horizontal slats. It stands at the
/// origin and faces +Z.
pub fn chair(wood: &Material) -> Piece {
    let mut chair = Piece::default();
    let half = Vec3::new(0.19, 0.0, 0.19);
    chair.flat(wood, legs(half, 0.44, 0.036));
    chair.flat(
        wood,
        Shape::chunk(Vec3::new(0.0, 0.455, 0.0), Vec3::new(0.44, 0.035, 0.44)),
    );
    for x in [-0.19, 0.19] {
        chair.flat(
            wood,
            Shape::chunk(Vec3::new(x, 0.7, -0.192), Vec3::new(0.034, 0.5, 0.03)),
        );
    }
    for y in [0.62, 0.74, 0.88] {
        chair.flat(
            wood,
            Shape::chunk(Vec3::new(0.0, y, -0.19), Vec3::new(0.39, 0.07, 0.016)),
        );
    }
    chair
}

/// An armchair, about 0.9 m wide and 1 m high: cushions of the material `cloth` on short legs of the material
/// `wood`. It stands at the origin and faces +Z.
pub fn armchair(cloth: &Material, wood: &Material) -> Piece {
    let mut chair = Piece::default();
    chair.flat(wood, legs(Vec3::new(0.32, 0.0, 0.3), 0.2, 0.05));
    let mut cushion = |x: f32, y: f32, z: f32, size: Vec3, radius: f32| {
        chair.smooth(cloth, soft_box(Vec3::new(x, y, z), size, radius));
    };
    cushion(0.0, 0.26, 0.0, Vec3::new(0.78, 0.22, 0.78), 0.04);
    cushion(0.0, 0.43, 0.06, Vec3::new(0.56, 0.17, 0.68), 0.07);
    cushion(0.0, 0.62, -0.33, Vec3::new(0.76, 0.72, 0.18), 0.08);
    cushion(0.0, 0.68, -0.21, Vec3::new(0.5, 0.4, 0.16), 0.07);
    for x in [-0.36, 0.36] {
        cushion(x, 0.44, 0.02, Vec3::new(0.16, 0.36, 0.76), 0.07);
    }
    chair
}

/// A round table on one foot, which stands at the origin. `radius` is the radius of its top, and `height` is
/// the height of the upper side of the top, in metres.
pub fn round_table(wood: &Material, radius: f32, height: f32) -> Piece {
    let mut table = Piece::default();
    let (h, r) = (height, radius);
    let foot = [
        (0.55 * r, 0.0),
        (0.54 * r, 0.03),
        (0.2 * r, 0.07),
        (0.06, 0.2),
    ];
    let column = [
        (0.06, 0.2),
        (0.035, 0.35 * h),
        (0.05, 0.7 * h),
        (0.09, h - 0.03),
    ];
    let top = [(r - 0.015, h - 0.032), (r, h - 0.016), (r - 0.01, h)];
    table.smooth(
        wood,
        lathe(
            &[
                &foot,
                &column,
                &[(0.09, h - 0.032), (r - 0.015, h - 0.032)],
                &top,
                &[(r - 0.01, h), (0.0, h)],
            ],
            64,
        ),
    );
    table
}

/// A bookcase full of books, `width` × `height` metres and 0.28 m deep. It stands at the origin, with its
/// open front towards +Z. `random` chooses the sizes and colours of the books.
pub fn bookcase(wood: &Material, width: f32, height: f32, random: &mut Random) -> Piece {
    let mut case = Piece::default();
    let deep = 0.28;
    for x in [-1.0, 1.0] {
        let middle = Vec3::new(x * (width / 2.0 - 0.012), height / 2.0, 0.0);
        case.flat(wood, Shape::chunk(middle, Vec3::new(0.024, height, deep)));
    }
    let back = Vec3::new(0.0, height / 2.0, -deep / 2.0 + 0.014);
    case.flat(
        wood,
        Shape::chunk(back, Vec3::new(width - 0.04, height - 0.02, 0.012)),
    );
    let shelves = (height / 0.34) as u32;
    let step = (height - 0.1) / shelves as f32;
    let inner = width / 2.0 - 0.03;
    for shelf in 0..=shelves {
        let y = 0.07 + shelf as f32 * step;
        let board = Vec3::new(0.0, y, 0.004);
        case.flat(
            wood,
            Shape::chunk(board, Vec3::new(width - 0.03, 0.022, deep - 0.014)),
        );
        if shelf == shelves {
            break;
        }
        let mut x = -inner;
        loop {
            // Some rows end early or have a gap.
            x += random.pick(&[0.002, 0.002, 0.002, 0.002, 0.002, 0.12]);
            let thick = random.between(0.018, 0.05);
            if x + thick > inner {
                break;
            }
            let size = Vec3::new(
                thick,
                step * random.between(0.58, 0.84),
                random.between(0.13, 0.19),
            );
            let front = 0.1 - random.between(0.0, 0.02);
            let middle = Vec3::new(
                x + thick / 2.0,
                y + 0.0112 + size.y / 2.0,
                front - size.z / 2.0,
            );
            case.flat(&book(random), Shape::chunk(middle, size));
            x += thick;
        }
    }
    case
}

/// The material of one book: a dielectric of roughness 0.5. `random` chooses one of seven colours.
pub fn book(random: &mut Random) -> Material {
    let cover = random.pick(&[
        [0.35, 0.05, 0.05],
        [0.05, 0.12, 0.3],
        [0.06, 0.22, 0.12],
        [0.5, 0.35, 0.1],
        [0.55, 0.5, 0.4],
        [0.1, 0.08, 0.08],
        [0.4, 0.16, 0.05],
    ]);
    dielectric("book", Vec3::from(cover), 0.5)
}

/// A framed picture to hang on a wall, `width` × `height` metres, of coloured rectangles that `random`
/// chooses. It is centred at the origin and faces +Z, with its back at about z = 0.
pub fn picture(frame: &Material, width: f32, height: f32, random: &mut Random) -> Piece {
    let mut picture = Piece::default();
    picture.flat(
        frame,
        Shape::chunk(Vec3::Z * 0.005, Vec3::new(width, height, 0.03)),
    );
    let paper = Material::lambert("paper", Vec3::new(0.75, 0.72, 0.66));
    let (w, h) = (width - 0.08, height - 0.08);
    picture.flat(
        &paper,
        Shape::chunk(Vec3::Z * 0.015, Vec3::new(w, h, 0.014)),
    );
    let inks = [
        [0.6, 0.1, 0.06],
        [0.06, 0.15, 0.35],
        [0.75, 0.5, 0.08],
        [0.08, 0.08, 0.09],
    ];
    for step in 0..7 {
        let size = Vec3::new(
            random.between(0.12, 0.5) * w,
            random.between(0.1, 0.45) * h,
            0.01,
        );
        let free = Vec3::new(0.9 * w - size.x, 0.9 * h - size.y, 0.0) / 2.0;
        let x = random.between(-free.x, free.x);
        let y = random.between(-free.y, free.y);
        // Each field is a little higher, so that no two are in the same plane.
        let middle = Vec3::new(x, y, 0.018 + 0.0004 * step as f32);
        let ink = Material::lambert("ink", Vec3::from(random.pick(&inks)));
        picture.flat(&ink, Shape::chunk(middle, size));
    }
    picture
}

/// A vase of the material `glaze` with a narrow neck, `height` metres high and open at the top. It stands at
/// the origin; its largest radius is about 0.36 × `height`.
pub fn vase(glaze: &Material, height: f32) -> Piece {
    let mut vase = Piece::default();
    let side = [
        (0.2, 0.0),
        (0.36, 0.25),
        (0.33, 0.55),
        (0.13, 0.78),
        (0.12, 0.88),
        (0.2, 1.0),
    ];
    let inside = [(0.18, 1.0), (0.1, 0.88), (0.1, 0.75), (0.0, 0.7)];
    let scaled = |points: &[(f32, f32)]| -> Vec<_> {
        points
            .iter()
            .map(|p| (p.0 * height, p.1 * height))
            .collect()
    };
    let (side, inside) = (scaled(&side), scaled(&inside));
    let lip = [side[side.len() - 1], inside[0]];
    let foot = [(0.0, 0.0), side[0]];
    vase.smooth(glaze, lathe(&[&foot, &side, &lip, &inside], 48));
    vase
}

/// A potted plant with 26 long bent leaves, up to about 1.4 m high. It stands at the origin. `random` chooses
/// the lengths and directions of the leaves.
pub fn plant(pot: &Material, leaf: &Material, random: &mut Random) -> Piece {
    let mut plant = Piece::default();
    let outside = [(0.12, 0.0), (0.17, 0.2), (0.19, 0.36)];
    let inside = [(0.175, 0.36), (0.16, 0.32), (0.0, 0.31)];
    let lip = [outside[2], inside[0]];
    plant.smooth(
        pot,
        lathe(&[&[(0.0, 0.0), outside[0]], &outside, &lip, &inside], 40),
    );
    const STEPS: usize = 7;
    for index in 0..26 {
        let turn = index as f32 * 2.4 + random.between(-0.3, 0.3);
        let (out, across) = (
            Vec3::new(turn.cos(), 0.0, turn.sin()),
            Vec3::new(-turn.sin(), 0.0, turn.cos()),
        );
        let (length, droop) = (random.between(0.6, 1.15), random.between(0.25, 0.95));
        let middle = |k: usize| {
            let t = k as f32 / STEPS as f32;
            let lean = t * droop * 1.5;
            Vec3::Y * (0.29 + length * t * (lean * 0.8).cos()) + out * length * t * lean.sin()
        };
        let half = |k: usize| {
            let t = k as f32 / STEPS as f32;
            across * 0.034 * (t * 2.8 + 0.25).sin()
        };
        for k in 0..STEPS {
            let [a, b] = [middle(k) - half(k), middle(k) + half(k)];
            let [c, d] = [middle(k + 1) + half(k + 1), middle(k + 1) - half(k + 1)];
            plant.flat(leaf, Shape::triangles(&[a, b, c, a, c, d]));
        }
    }
    plant
}

/// A standing lamp with a shade, 1.66 m high, at the origin. It is switched off: it emits no light, and only
/// reflects light and casts shadows.
pub fn dark_lamp(iron: &Material, shade: &Material) -> Piece {
    let mut lamp = Piece::default();
    let pole = [(0.15, 0.0), (0.14, 0.025), (0.02, 0.04), (0.012, 0.1)];
    lamp.smooth(iron, lathe(&[&pole, &[(0.012, 0.1), (0.012, 1.5)]], 32));
    let (foot, top) = ((0.21, 1.34), (0.13, 1.66));
    let (inner_foot, inner_top) = ((0.207, 1.34), (0.127, 1.66));
    let walls = [
        [foot, top],
        [top, inner_top],
        [inner_top, inner_foot],
        [inner_foot, foot],
    ];
    lamp.smooth(shade, lathe(&walls.each_ref().map(|wall| &wall[..]), 48));
    lamp
}

/// A silver bowl with four fruits, 0.32 m wide, which stands at the origin. `random` chooses the colours of
/// the fruits.
pub fn fruit_bowl(random: &mut Random) -> Piece {
    let mut bowl = Piece::default();
    let outside = [(0.06, 0.0), (0.12, 0.03), (0.16, 0.09)];
    let inside = [(0.153, 0.09), (0.11, 0.036), (0.0, 0.015)];
    let lip = [outside[2], inside[0]];
    let silver = metal("silver", Vec3::new(0.9, 0.88, 0.84), 0.2);
    bowl.smooth(
        &silver,
        lathe(&[&[(0.0, 0.0), outside[0]], &outside, &lip, &inside], 48),
    );
    for (x, y, z) in [
        (0.0, 0.06, 0.05),
        (-0.05, 0.06, -0.03),
        (0.05, 0.06, -0.03),
        (0.0, 0.115, 0.0),
    ] {
        let skin = random.pick(&[[0.6, 0.08, 0.04], [0.75, 0.35, 0.03], [0.3, 0.45, 0.06]]);
        let fruit = Shape::sphere(3).map(|n| n * 0.038 + Vec3::new(x, y, z));
        bowl.smooth(&dielectric("fruit", Vec3::from(skin), 0.4), fruit);
    }
    bowl
}

/// A low cupboard on legs, `width` metres wide and 0.8 m high, which stands at the origin. Its front, towards
/// +Z, has two doors, each with a knob of the material `knob`.
pub fn sideboard(wood: &Material, knob: &Material, width: f32) -> Piece {
    let mut board = Piece::default();
    board.flat(
        wood,
        legs(Vec3::new(width / 2.0 - 0.06, 0.0, 0.15), 0.2, 0.04),
    );
    board.flat(
        wood,
        Shape::chunk(Vec3::new(0.0, 0.47, 0.0), Vec3::new(width, 0.6, 0.4)),
    );
    board.flat(
        wood,
        Shape::chunk(
            Vec3::new(0.0, 0.78, 0.005),
            Vec3::new(width + 0.04, 0.03, 0.44),
        ),
    );
    for side in [-1.0, 1.0] {
        let middle = Vec3::new(side * width / 4.0, 0.47, 0.2);
        board.flat(
            wood,
            Shape::chunk(middle, Vec3::new(width / 2.0 - 0.03, 0.54, 0.024)),
        );
        let at = Vec3::new(side * 0.06, 0.5, 0.225);
        board.smooth(knob, Shape::sphere(2).map(|n| n * 0.016 + at));
    }
    board
}
