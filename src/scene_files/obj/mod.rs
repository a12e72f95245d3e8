//! Reads Wavefront OBJ files: polygons in objects and groups, with materials from MTL files.
//!
//! This reader replaces the `tobj` crate. Errors of that crate name no line, it takes 4.4 times the size of a file in
//! memory, and its version 4.0.5 fails on these files:
//!
//! - it panics on a colour of one or two numbers in an MTL file, such as `Kd 0.5`;
//! - it refuses Latin-1 in names and comments, lines continued by `\`, comments behind the numbers of a vertex or a face,
//!   colours on some vertices only, colours with alpha, and a tab behind `usemtl`;
//! - it drops all materials of an MTL file with Latin-1, a continued line or `d -halo 0.5`;
//! - it ignores the face statement `fo`;
//! - it builds wrong meshes: if only some faces have normals, the other faces get normals too; concave polygons get
//!   triangles outside of their outline; a line `l 1 2 3` or a face of two corners becomes a triangle;
//! - it accepts `nan`, numbers beyond f32, and indices of normals in a file without normals. It reads a text that is no OBJ
//!   as an empty scene.
//!
//! Each `o` or `g` statement begins a mesh, which has one part for each of its materials. [`super::polygon`] cuts polygons
//! into triangles, concave ones too. Free-form curves and surfaces are skipped.

mod blocks;
mod building;
mod colors;
mod combine;
mod faces;
mod ignored;
mod libraries;
mod lines;
mod map_statements;
mod maps;
mod mtl;
mod plain;
mod reading;
mod smoothing;

use super::progress::Progress;
use super::scene_folder::SceneFolder;
use crate::Result;
use crate::base::memory;
use crate::scene::notices::{Tally, quoted};
use crate::scene::{Instance, Material, Scene};
use building::{Attributes, Building, Corner, join_parts};
use faces::{CORNER_BYTES, Index};
use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use ignored::Ignored;
use libraries::{MaterialNames, Named};
use lines::Line;
use mtl::Maps;
use smoothing::Smoothing;
use std::collections::{HashMap, HashSet};
use std::fs::File;

/// The base colour, in linear RGB, of faces without a material, and of materials for which the MTL file states no base
/// colour (`Kd`).
const GREY: Vec3 = Vec3::splat(0.8);

/// The memory, in bytes, that a mesh without vertices and triangles takes together with its instance. Each `o` and `g`
/// statement begins a mesh, so the reader checks at each of them that this much memory is free. If it is not, loading ends
/// with an error.
const MESH_BYTES: u64 = 1 << 10;

/// Reads an OBJ file and the MTL files in `folder` that it names; `length` is the size of the OBJ file in bytes. Errors name
/// the line in the file, but not the OBJ file, which the caller adds. The returned scene is not validated yet, and its
/// textures are loaded later.
///
/// If the file names an MTL file only after its materials are used, it is read twice: the second time with the materials.
///
/// # Errors
/// A statement of the OBJ file or of an MTL file is wrong; the text contains no statement of OBJ, but other text; a file
/// cannot be read or is too large; or there is not enough memory.
pub(super) fn read(
    file: &File,
    length: u64,
    folder: &SceneFolder<'_>,
    progress: &mut Progress<'_>,
) -> Result<Untextured> {
    let mut reader = Reader::new(folder);
    reader.read(file, length, progress)?;
    let Some((number, name)) = reader.late_material() else {
        return Ok(reader.finish());
    };
    let location = format!("line {number}: {}", quoted(name));
    let library_lines = reader.library_lines;
    let mut reader = Reader::new(folder);
    let what = "MTL files are read first, because they are named after the use of a material";
    reader.ignored.tally.add(what, || location);
    for (number, rest) in &library_lines {
        reader.material_library(&Line::material_library(*number, rest))?;
    }
    progress.add_to_read(length);
    reader.read(file, length, progress)?;
    Ok(reader.finish())
}

/// The scene of an OBJ file whose textures are not loaded yet. [`Self::load_textures`] loads them after the whole file is
/// read, because only then is it known which materials have faces; only the images of these materials are read.
pub(super) struct Untextured {
    scene: Scene,
    maps: Vec<Maps>,
    tally: Tally,
}

impl Untextured {
    /// Loads the textures of the materials that faces use; their image files lie in `folder`. Returns the finished scene.
    /// The notices of the result list what the reader assumed and ignored.
    ///
    /// # Errors
    /// The errors of [`maps::load`], for example an image file that is damaged, or one that is missing without the user's
    /// permission.
    pub fn load_textures(
        self,
        folder: &SceneFolder<'_>,
        progress: &mut Progress<'_>,
    ) -> Result<Scene> {
        let Self {
            mut scene,
            maps,
            mut tally,
        } = self;
        maps::load(&mut scene, &maps, folder, progress, &mut tally)?;
        scene.notices.extend(tally.into_lines());
        Ok(scene)
    }
}

struct Reader<'a> {
    folder: &'a SceneFolder<'a>,
    positions: Vec<DVec3>,
    /// The origin of the current mesh, in the coordinates of the file. The mesh stores its positions relative to this point,
    /// so that f32 is precise enough far from the file's origin.
    center: DVec3,
    /// The length that `positions` had when the origin of a mesh was last computed. The origin of the next
    /// mesh is computed from the positions after these. If there are none, as in a file that lists all
    /// positions first, the next mesh keeps the last origin.
    centered: usize,
    attributes: Attributes,
    smoothing: Smoothing,
    scene: Scene,
    /// The textures that MTL files state for the materials of the scene: one entry for each material, in the same order.
    /// Their images are loaded after the whole OBJ file is read.
    maps: Vec<Maps>,
    materials: MaterialNames,
    /// The names of materials that were in no MTL file when they were used, with the number of the line where each name was
    /// used first.
    unknown_materials: HashMap<String, usize>,
    /// The `mtllib` statements: number of the line, and the text after the keyword.
    library_lines: Vec<(usize, String)>,
    /// The device and inode numbers of the MTL files that were read, so that each file is read once, even under several
    /// names.
    libraries: HashSet<(u64, u64)>,
    /// The names after `mtllib` that were looked up, so that each name is looked up once, also if there is no such file.
    library_names: HashSet<String>,
    /// The material of the faces that follow, as an index into the scene's materials. `None` if the file has not named a
    /// material for them or has named an unknown one; such faces are grey.
    material: Option<u32>,
    grey: Option<u32>,
    mesh: Building,
    ignored: Ignored,
    /// The corners of the current face. The list is used only while a face is processed; it is a field so that its memory is
    /// reused for the next face.
    corners: Vec<Corner>,
    /// The positions of the current face's corners relative to the mesh's origin, in the order of `corners`, from which the
    /// face is cut into triangles. The list is used only while a face is processed; it is a field so that its memory is
    /// reused for the next face.
    points: Vec<Vec3>,
}

impl<'a> Reader<'a> {
    fn new(folder: &'a SceneFolder<'a>) -> Self {
        Self {
            folder,
            positions: Vec::new(),
            center: DVec3::ZERO,
            centered: 0,
            attributes: Attributes::default(),
            smoothing: Smoothing::default(),
            scene: Scene::default(),
            maps: Vec::new(),
            materials: MaterialNames::default(),
            unknown_materials: HashMap::new(),
            library_lines: Vec::new(),
            libraries: HashSet::new(),
            library_names: HashSet::new(),
            material: None,
            grey: None,
            mesh: Building::default(),
            ignored: Ignored::default(),
            corners: Vec::new(),
            points: Vec::new(),
        }
    }

    /// Processes one statement of the OBJ file. Returns true if its keyword belongs to OBJ, even if the reader does not
    /// support it and ignores the statement. Fails if the words after the keyword are wrong, or if there is not enough
    /// memory.
    fn statement(&mut self, line: &Line) -> Result<bool> {
        match line.keyword {
            "v" => {
                self.positions.push(line.numbers()?.into());
                let colors = &mut self.attributes.colors;
                if !colors.read(line, self.positions.len() - 1) {
                    let what = "words behind the position of a vertex are ignored";
                    self.ignored.tally.add(what, || line.location());
                }
            }
            "vn" => {
                // Validation reports a normal of zero length where a face uses it.
                let normal = line.numbers().map(|n| DVec3::from(n).as_vec3());
                self.attributes.normals.push(normal.unwrap_or(Vec3::ZERO));
            }
            "vt" => {
                let mut words = line.words();
                // What is no number counts only where a texture uses it.
                let mut number = || {
                    words
                        .next()
                        .map_or(0.0, |word| word.parse().unwrap_or(f32::NAN))
                };
                self.attributes
                    .coordinates
                    .push(Vec2::new(number(), number()));
            }
            "f" | "fo" => {
                check_memory(line, line.rest.len() as u64 * CORNER_BYTES / 2)?;
                self.face(line, line.words().map(Index::of_corner))?;
            }
            "o" | "g" => {
                check_memory(line, MESH_BYTES)?;
                self.finish_mesh();
                self.mesh.mesh.name = line.rest.to_owned();
            }
            "usemtl" => self.use_material(line)?,
            "mtllib" => self.material_library(line)?,
            "s" => {
                if !self.smoothing.begin_group(line.rest) {
                    let what = "smoothing groups that are no numbers are flat";
                    self.ignored.tally.add(what, || line.location());
                }
            }
            "usemap" => {
                let what = "textures by usemap are ignored";
                self.ignored.tally.add(what, || line.location());
            }
            "p" | "l" => self
                .ignored
                .tally
                .add("points and lines are skipped", || line.location()),
            "curv" | "curv2" | "surf" => self
                .ignored
                .tally
                .add("free-form curves and surfaces are skipped", || {
                    line.location()
                }),
            "vp" | "mg" | "cstype" | "deg" | "bmat" | "step" | "parm" | "trim" | "hole"
            | "scrv" | "sp" | "end" | "con" | "bevel" | "c_interp" | "d_interp" | "lod"
            | "shadow_obj" | "trace_obj" | "ctech" | "stech" | "maplib" => {}
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn use_material(&mut self, line: &Line) -> Result<()> {
        let name = line.rest;
        self.material = match self.materials.find(name) {
            Named::Exact(material) => Some(material),
            Named::OtherCase(material) => {
                let what = "names of materials are matched without regard to letter case";
                let found = &self.scene.materials[material as usize].name;
                self.ignored.tally.add(what, || {
                    let (name, found) = (quoted(name), quoted(found));
                    format!("{}: {name} is {found}", line.location())
                });
                Some(material)
            }
            Named::Unknown => {
                let what = "materials that are in no MTL file are grey (0.8)";
                self.ignored
                    .tally
                    .add(what, || format!("{}: {}", line.location(), quoted(name)));
                if !self.unknown_materials.contains_key(name) {
                    check_memory(line, 2 * (name.len() as u64 + libraries::NAME_BYTES))?;
                    self.unknown_materials
                        .insert(name.to_owned(), line.number());
                }
                None
            }
        };
        Ok(())
    }

    /// The first use of a material that was in no MTL file then, but is in one that the file names later: the number of the
    /// line and the name.
    fn late_material(&self) -> Option<(usize, &str)> {
        let used = self.unknown_materials.iter();
        used.filter(|(name, _)| !matches!(self.materials.find(name), Named::Unknown))
            .map(|(name, line)| (*line, name.as_str()))
            .min()
    }

    /// The index, among the scene's materials, of the grey material for faces without a material. This function adds the
    /// material to the scene when it is needed for the first time.
    fn grey(&mut self) -> u32 {
        *self.grey.get_or_insert_with(|| {
            self.scene.materials.push(Material::lambert("", GREY));
            self.maps.push(Maps::default());
            self.scene.materials.len() as u32 - 1
        })
    }

    /// Ends the current mesh at an `o` or `g` statement or at the end of the file, and begins an empty one. If the current
    /// mesh has triangles, the mesh and an instance of it are added to the scene; otherwise it is dropped.
    fn finish_mesh(&mut self) {
        let next = self.mesh.next();
        let mut building = std::mem::replace(&mut self.mesh, next);
        let mut mesh = std::mem::take(&mut building.mesh);
        if mesh.triangles.is_empty() {
            return;
        }
        if !building.has_stated_normals && building.smooth.is_empty() {
            mesh.normals = Vec::new();
        }
        if building.has_coordinates {
            mesh.uvs[0].resize(mesh.positions.len(), Vec2::ZERO);
        }
        if !mesh.colors.is_empty() {
            mesh.colors.resize(mesh.positions.len(), Vec4::NAN);
        }
        self.smoothing
            .finish_mesh(self.scene.meshes.len(), &mut building);
        join_parts(&mut mesh);
        self.scene.instances.push(Instance {
            name: mesh.name.clone(),
            mesh: self.scene.meshes.len() as u32,
            object_to_world: DAffine3::from_translation(self.center),
        });
        self.scene.meshes.push(mesh);
    }

    fn finish(mut self) -> Untextured {
        self.finish_mesh();
        self.finish_colors();
        self.smoothing.finish(&mut self.scene);
        if self.grey.is_some() {
            self.ignored
                .tally
                .add("faces without a material are given one", || {
                    "grey Lambert (0.8)".to_owned()
                });
        }
        Untextured {
            scene: self.scene,
            maps: self.maps,
            tally: self.ignored.into_tally(),
        }
    }
}

/// Checks that at least `bytes` bytes of memory are free for the data of the statement `line`, before they
/// are allocated. Fails if less is free; the error names the statement.
fn check_memory(line: &Line, bytes: u64) -> Result<()> {
    memory::check(bytes).map_err(|cause| line.wrong(&format!("{cause}; give a smaller scene")))
}
