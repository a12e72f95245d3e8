//! Tests of the bias check: a part of the bias matrix passes, and the same command fails for each known fault of a merge,
//! planted in a copy of the shaders.

mod support;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;
use support::{TOY_LOBES, planted, said};

/// The condition in `merge.glsl` under which a target function tests visibility with a ray of its own, as the balance
/// heuristic does. Faults replace it and `PASSED`, which is the ray that stands for many samples in pairwise weights.
const UNSEEN: &str = "visibility && i != k &&";
const PASSED: &str = "= transmittance(viewer, shading_point, value);";

/// The folder of references that studies of this file share. A fault is usually in a file that path tracing does not
/// include, so the reference with the fault is the same as without it.
static REFERENCES: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bias-references");
    // Those of an earlier run may be of other code.
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
});

/// Copies references that `to` lacks from `from`.
fn copy_references(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for file in from.read_dir().unwrap() {
        let file = file.unwrap();
        let target = to.join(file.file_name());
        // The copies that other tests are at work on begin with a dot.
        let is_whole = !file.file_name().to_string_lossy().starts_with('.');
        if is_whole && !target.exists() {
            // Tests run side by side, and no one may see half a file.
            let copy = tempfile::NamedTempFile::new_in(to).unwrap();
            std::fs::copy(file.path(), copy.path()).unwrap();
            copy.persist(target).unwrap();
        }
    }
}

fn study(plan: &str, folder: &Path, shaders: Option<&Path>) -> Output {
    let references = folder.join("references");
    copy_references(&REFERENCES, &references);
    let output = study_alone(plan, folder, shaders);
    copy_references(&references, &REFERENCES);
    output
}

fn study_alone(plan: &str, folder: &Path, shaders: Option<&Path>) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_headwater"));
    command.args(["study", "--plan", plan, "-o"]).arg(folder);
    // The validation layers keep something of every submission and crash after some ten thousand; a
    // shorter study runs with them among the tests of the command line.
    command.env_remove("HEADWATER_VALIDATION");
    if let Some(shaders) = shaders {
        command.env("HEADWATER_GLSL", shaders);
    }
    command.output().unwrap()
}

fn assert_sample_passes(plan: &str) {
    let folder = tempfile::tempdir().unwrap();
    let output = study(plan, folder.path(), None);
    println!("{}", said(&output));
    assert!(output.status.success());
    // What is biased is seen to be.
    let json = std::fs::read_to_string(folder.path().join("results.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    for row in json["rows"].as_array().unwrap() {
        let expected = row["expect"].as_str().unwrap();
        assert_eq!(row["verdict"].as_str().unwrap(), expected, "{row:#}");
    }
}

/// A short study plan that passes without faults, and fails with every fault for which no other plan is named.
const PLAN: &str = r#"
scenes = ["cornell"]
width = 48
frames = 3
seeds = 64
bounces = 1
reference_spp = 1024
[[sweeps]]
preset = "accurate"
[sweeps.over]
"direct.mis" = ["balance", "pairwise", "defensive"]
"direct.reuse" = ["spatiotemporal"]
"#;

/// Runs the plan `PLAN` with changed shaders. Returns true if the study proves the absence of bias, and its output.
fn with_fault(changes: &[(&str, &str, &str)]) -> (bool, String) {
    study_with_fault(PLAN, changes)
}

/// Runs a plan with changed shaders. Returns true if the study proves the absence of bias, and its output.
fn study_with_fault(text_of_plan: &str, changes: &[(&str, &str, &str)]) -> (bool, String) {
    let folder = tempfile::tempdir().unwrap();
    let shaders = folder.path().join("glsl");
    planted(&shaders, changes);
    let plan = folder.path().join("plan.toml");
    std::fs::write(&plan, text_of_plan).unwrap();
    let output = study(plan.to_str().unwrap(), folder.path(), Some(&shaders));
    println!("{}", said(&output));
    // Too few seeds to tell would be no proof.
    let passes = output.status.success() && !said(&output).contains("undecided");
    (passes, said(&output))
}

/// Asserts that a plan passes, and that it fails with the fault.
fn assert_found(text_of_plan: &str, change: (&str, &str, &str)) {
    assert!(study_with_fault(text_of_plan, &[]).0);
    assert_biased(text_of_plan, change);
}

/// Asserts that a plan fails with the fault.
fn assert_biased(text_of_plan: &str, change: (&str, &str, &str)) {
    let (passes, said) = study_with_fault(text_of_plan, &[change]);
    assert!(!passes && said.contains("should be unbiased"));
}

/// A short plan for faults that only glossy surfaces show.
fn glossy_plan(seeds: u32, settings: &str) -> String {
    format!(
        r#"
scenes = ["cornell-glossy"]
width = 48
frames = 3
seeds = {seeds}
bounces = 1
reference_spp = 2048
[[configurations]]
name = "glossy"
preset = "accurate"
set = {{ {settings} }}
"#
    )
}

/// Asserts that a study failed for all unbiased weights: balance, pairwise and defensive.
fn assert_all_fail(passes: bool, said: &str) {
    let failed = |mis: &str| {
        said.contains(&format!(
            "{mis}/spatiotemporal on cornell (should be unbiased)"
        ))
    };
    assert!(!passes && ["balance", "pairwise", "defensive"].into_iter().all(failed));
}

#[test]
fn without_a_fault_the_short_plan_passes() {
    assert!(with_fault(&[]).0);
}

/// The best-known fault: a neighbour in shadow has no sample, and leaving its empty reservoir out of the merge biases the
/// result.
#[test]
fn empty_neighbours_that_are_skipped_are_found() {
    let (passes, said) = with_fault(&[
        (
            "restir/merge.glsl",
            "neighbour_confidence += confidence_of(i);",
            "if (technique_at(i).contribution_weight > 0.0) neighbour_confidence += confidence_of(i);",
        ),
        (
            "restir/merge.glsl",
            "ShadingPoint there = shading_point_of(i);",
            "if (i > 0u && !(technique_at(i).contribution_weight > 0.0)) continue; ShadingPoint there = shading_point_of(i);",
        ),
        (
            "restir/merge.glsl",
            "if (!needs_target(mis, i, k)) continue;",
            "if (!needs_target(mis, i, k) || (k > 0u && !(technique_at(k).contribution_weight > 0.0))) continue;",
        ),
    ]);
    assert_all_fail(passes, &said);
}

/// A BSDF ray and the hash grid can draw the same sample, so MIS weights must count both. The fault is visible with few
/// light samples only.
#[test]
fn hits_that_know_nothing_of_the_hash_grid_are_found() {
    let settings = r#""direct.candidates" = "hash-grid", "direct.light_samples" = 1"#;
    assert_found(
        &glossy_plan(64, settings),
        (
            "restir/passes/initial_direct.comp",
            "if (weight > 0.0) weight *= pixel_weight(value, target);",
            "",
        ),
    );
}

/// Without the Jacobian, a neighbour's path counts as if both pixels saw its second vertex under the same solid angle. For
/// close neighbours that is nearly true, and the error cancels over the picture, so the plan uses distant neighbours.
#[test]
fn a_jacobian_that_is_dropped_is_found() {
    let plan = r#"
scenes = ["cornell"]
width = 48
frames = 3
seeds = 64
bounces = 2
reference_spp = 8192
[[configurations]]
name = "neighbours far away"
preset = "accurate"
[configurations.set]
"direct.reuse" = "none"
"indirect.reuse" = "spatial"
"indirect.mis" = "pairwise"
"indirect.jacobian_limit" = 0
"indirect.spatial.passes" = 2
"indirect.spatial.neighbours" = 8
"indirect.spatial.radius" = 40
"indirect.similar.normal" = 180
"indirect.similar.depth" = 10
"indirect.similar.material" = false
"#;
    assert_found(
        plan,
        (
            "restir/samples/path_sample.glsl",
            "vec3(solid_angle), pdf_solid_angle",
            "vec3(1.0), pdf_solid_angle",
        ),
    );
}

/// A plan for light of two bounces or more with world reservoirs; `scene` is written as in a plan. It measures the mean of
/// all frames, which is more precise in the same time than the last frame, since all frames draw new samples. The first
/// frame, which reuses nothing, makes a bias slightly smaller.
fn world_plan(scene: &str, most_seeds: u32, reference_spp: u32, settings: &str) -> String {
    format!(
        r#"
scenes = [{scene}]
width = 48
frames = 12
seeds = 32
most_seeds = {most_seeds}
bounces = 3
reference_spp = {reference_spp}
[[sweeps]]
preset = "accurate"
accumulate = true
[sweeps.set]
"direct.mode" = "off"
"indirect.mode" = "path"
"indirect.secondary" = "world-reservoirs"
"indirect.light_samples" = 1
"world_reservoirs.min_lights" = 0
"world_reservoirs.depth" = 2
[sweeps.over]
{settings}
"#
    )
}

/// The MIS weight against BSDF rays belongs to the vertex that shades a sample. The fault is to include it in the weights
/// that other vertices reuse.
#[test]
fn an_mis_weight_in_world_reservoirs_is_found() {
    assert_found(
        &world_plan(
            r#""cornell""#,
            1536,
            4096,
            r#""world_reservoirs.stores" = ["initial"]"#,
        ),
        (
            "restir/samples/path_candidates.glsl",
            "candidate_weight(stored, value, light_pdf, light_samples, 0u, target)",
            "candidate_weight(stored, value, light_pdf, light_samples, 1u, target)",
        ),
    );
}

const CHEQUERED_MATERIALS: &str = "\
newmtl red
Kd 1 0 0
newmtl white
Kd 0.8 0.8 0.8
newmtl lamp
Kd 0 0 0
Ke 0 0 20
";

/// A glTF scene with a red and white floor in front of a white wall, under a blue emitter.
fn chequered_floor() -> String {
    let mut text = String::from("mtllib chequered.mtl\n");
    let mut square = |material: &str, corners: [[f32; 3]; 4]| {
        text += &format!("usemtl {material}\n");
        for [x, y, z] in corners {
            text += &format!("v {x} {y} {z}\n");
        }
        text += "f -4 -3 -2 -1\n";
    };
    for tile in 0_u8..64 {
        let (x, z) = (f32::from(tile % 8) - 4.0, f32::from(tile / 8) - 4.0);
        let material = ["red", "white"][usize::from((tile % 8 + tile / 8) % 2)];
        square(
            material,
            [
                [x, 0.0, z],
                [x, 0.0, z + 1.0],
                [x + 1.0, 0.0, z + 1.0],
                [x + 1.0, 0.0, z],
            ],
        );
    }
    square(
        "white",
        [
            [-4.0, 0.0, -4.0],
            [4.0, 0.0, -4.0],
            [4.0, 4.0, -4.0],
            [-4.0, 4.0, -4.0],
        ],
    );
    square(
        "lamp",
        [
            [-0.5, 3.0, -0.5],
            [0.5, 3.0, -0.5],
            [0.5, 3.0, 0.5],
            [-0.5, 3.0, 0.5],
        ],
    );
    text
}

mod thorough {
    use super::*;

    /// Surfaces with two delta lobes and two or more wide lobes are unbiased. The planted fault follows only two paths per
    /// pixel, which is right for one delta lobe.
    #[test]
    fn two_more_lobes_are_unbiased_and_a_lost_path_is_found() {
        let plan = r#"
scenes = ["cornell:finish=lacquer,roughness=0"]
width = 48
frames = 3
seeds = 256
most_seeds = 1024
bounces = 3
reference_spp = 8192
[[configurations]]
name = "toy lobes"
preset = "accurate"
"#;
        let (passes, said) = study_with_fault(plan, &TOY_LOBES);
        assert!(passes, "{said}");
        let mut changes = TOY_LOBES.to_vec();
        changes.push((
            "restir/passes/initial_indirect.comp",
            "paths_begun > MAX_DELTA_LOBES + 1u",
            "paths_begun > 2u",
        ));
        let (passes, said) = study_with_fault(plan, &changes);
        assert!(!passes && said.contains("should be unbiased"));
    }

    #[test]
    fn a_sample_of_the_bias_matrix_passes() {
        assert_sample_passes("bias-sample");
    }

    #[test]
    fn a_sample_of_the_bias_matrix_of_indirect_light_passes() {
        assert_sample_passes("indirect-sample");
    }

    #[test]
    fn confidence_that_depends_on_the_sample_is_found() {
        let (passes, said) = with_fault(&[(
            "restir/spatial.glsl",
            "return limited(technique, stored_confidence(slot_of(pixels[technique])));",
            "float confidence = limited(technique, stored_confidence(slot_of(pixels[technique])));
            uint light = neighbours.at[word_of(slot_of(pixels[technique]), 2u, restir.at.slots)] & LIGHT_MASK;
            return light == 1u ? 0.25 * confidence : confidence;",
        )]);
        assert!(!passes && said.contains("should be unbiased"));
    }

    #[test]
    fn visibility_that_is_missing_at_the_pixel_itself_is_found() {
        let weighed = "visibility && i != k && k != 0u &&";
        let (passes, said) = with_fault(&[
            ("restir/merge.glsl", UNSEEN, weighed),
            (
                "restir/merge.glsl",
                PASSED,
                "= asks ? transmittance(viewer, shading_point, value) : 1.0;",
            ),
        ]);
        assert_all_fail(passes, &said);
    }

    #[test]
    fn visibility_that_is_missing_at_the_neighbours_is_found() {
        let weighed = "visibility && i != k && k == 0u &&";
        let (passes, said) = with_fault(&[
            ("restir/merge.glsl", UNSEEN, weighed),
            (
                "restir/merge.glsl",
                PASSED,
                "= asks ? 1.0 : transmittance(viewer, shading_point, value);",
            ),
        ]);
        assert_all_fail(passes, &said);
    }

    /// A pixel must not draw more BSDF candidates because its own first candidate was bright: this candidate would then
    /// count too little. The fault is visible with narrow lobes and few light samples only.
    #[test]
    fn candidates_that_their_own_pixel_counts_by_are_found() {
        assert_found(
            &glossy_plan(256, r#""direct.light_samples" = 1"#),
            (
                "restir/passes/initial_direct.comp",
                "LOAD_PILOT_BRIGHTNESS(pilots, slot_of(uvec2(other)))",
                "LOAD_PILOT_BRIGHTNESS(pilots, slot_of(uvec2(pixel)))",
            ),
        );
    }

    /// A merge that reads reservoirs while they are written is a race, so no two runs are equal. A busy machine may keep the
    /// order of threads twice by chance, so the test tries again.
    #[test]
    fn neighbours_that_are_read_while_they_are_written_are_found() {
        let faults = [
            (
                "restir/spatial.glsl",
                "layout(scalar) writeonly buffer ReservoirsBlock",
                "layout(scalar) buffer ReservoirsBlock",
            ),
            (
                "restir/spatial.glsl",
                "LOAD_RESERVOIR(neighbours, slot_of(pixels[technique])",
                "if (technique != 0u) { LOAD_RESERVOIR(reservoirs, slot_of(pixels[technique]), restir.at.slots, packed); }
                else LOAD_RESERVOIR(neighbours, slot_of(pixels[technique])",
            ),
        ];
        assert!((0..4).any(|_| {
            let (passes, said) = with_fault(&faults);
            !passes && said.contains("the same seed gives another picture")
        }));
    }
}

mod largest {
    use super::*;

    #[test]
    fn empty_world_reservoirs_that_are_skipped_are_found() {
        let change = (
            "world_reservoirs/world_reservoirs.glsl",
            "if (entry == 0u) continue;",
            "if (entry == 0u || !(previous_world_samples.at[(entry & WORLD_VERTEX_MASK) - 1u].weight > 0.0)) continue;",
        );
        let plan = |tables: &str| {
            let settings = format!(r#""world_reservoirs.table" = {tables}"#);
            world_plan(r#""motion""#, 2048, 16384, &settings)
        };
        // With 1e-9, all have one bucket, and nearly every vertex is dropped.
        assert!(study_with_fault(&plan("[0.25, 1e-9]"), &[]).0);
        assert_biased(&plan("[0.25]"), change);
    }

    /// Candidates among rare lights are divided by the probability of their draw and of their roulette. The faults leave one
    /// of these divisions out.
    #[test]
    fn fractions_of_rare_lights_that_are_forgotten_are_found() {
        let plan = |name: &str, bounces: u32, settings: &str| {
            format!(
                r#"
scenes = ["divided-room:lamps=4,wall=short,contrast=200"]
width = 32
frames = 8
seeds = 256
most_seeds = 2048
bounces = {bounces}
reference_spp = 8192
[[configurations]]
name = "{name}"
preset = "accurate"
accumulate = true
set = {{ {settings} }}
"#
            )
        };
        let direct = plan("direct", 1, r#""direct.reuse" = "none""#);
        assert_found(
            &direct,
            (
                "restir/passes/initial_direct.comp",
                "rare * (hit.transmittance / chance)",
                "rare * hit.transmittance",
            ),
        );
        let world = r#""direct.mode" = "off", "indirect.mode" = "path", "indirect.secondary" = "world-reservoirs", "world_reservoirs.min_lights" = 0"#;
        let indirect = plan("indirect", 3, world);
        let file = "restir/samples/path_candidates.glsl";
        assert_found(
            &indirect,
            (
                file,
                "(RARE_LIGHTS ? 1.0 - restir.at.reuse.rare_lights : 1.0)",
                "1.0",
            ),
        );
        let division = "if (RARE_LIGHTS && in_world) light /= 1.0 - restir.at.reuse.rare_lights;";
        assert_biased(&indirect, (file, division, ""));
    }

    /// The light sample that a vertex stores stands for a matte white point, which reflects every colour. A surface that
    /// does not reflect every colour must not store what it merged.
    #[test]
    fn colours_that_a_surface_does_not_reflect_stay_in_world_reservoirs() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("chequered.obj");
        std::fs::write(folder.path().join("chequered.mtl"), CHEQUERED_MATERIALS).unwrap();
        std::fs::write(&file, chequered_floor()).unwrap();
        let scene = format!(
            r#"{{ scene = "{}", look_at = "0,1.5,4,0,1,-2,45" }}"#,
            file.display()
        );
        assert_found(
            &world_plan(
                &scene,
                8192,
                65536,
                r#""world_reservoirs.stores" = ["merged"]"#,
            ),
            (
                "world_reservoirs/world_reservoirs.glsl",
                "min(diffuse.x, min(diffuse.y, diffuse.z)) > 0.01",
                "max_component(diffuse) > 0.01",
            ),
        );
    }
}
