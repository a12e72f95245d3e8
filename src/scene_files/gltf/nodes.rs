//! Reads the nodes of a scene: checks that they form trees, visits them without recursion, and multiplies their transforms
//! in f64.

use super::accessors::get;
use super::document::{Camera as FileCamera, Document, Node, Orthographic};
use super::{damaged, visibility};
use crate::scene::Camera;
use crate::scene::camera::{Projection, rigid};
use crate::scene::notices::{Tally, label};
use crate::scene::validate::LARGEST_COORDINATE;
use crate::{Error, Result};
use glam::{DAffine3, DMat4, DQuat, DVec3, DVec4};

/// A node that belongs to the scene, with its transform to its parent and its transform to the world. If animations change
/// these transforms, the values here are those that the nodes of the file state, without the animations. The scene's
/// instances, cameras, lights and motion are made from these nodes.
pub struct Placed<'a> {
    pub index: usize,
    pub node: &'a Node,
    /// The index of the parent in the list that [`placed`] returns; `None` for a node without a parent. It becomes
    /// [`Node::parent`](crate::scene::motion::Node::parent) in the motion, so that the node moves with its parent.
    pub parent: Option<u32>,
    pub in_parent: DAffine3,
    pub to_world: DAffine3,
    /// True if the node's mesh and light are shown; false if the node or an ancestor is hidden, or is a coarser level of
    /// detail of another node. The node's camera can be used in both cases.
    pub is_shown: bool,
}

impl Placed<'_> {
    /// The name of the node, such as `node 3 "Lamp"`. Errors and notices refer to the node by this text.
    pub fn label(&self) -> String {
        label("node", self.index, &self.node.name)
    }

    /// The name of the node or, if it is empty, `shown`, which is the name of the node's camera or light. The scene's camera
    /// or light gets this name. `shown` is cut after 256 characters, because very many nodes can refer to one camera or
    /// light, and each of them stores its own copy of the name.
    pub fn name_or(&self, shown: &str) -> String {
        match self.node.name.as_str() {
            "" => shown.chars().take(256).collect(),
            own => own.to_owned(),
        }
    }

    /// The node's scale, rotation (a unit quaternion) and translation in the file. A property without
    /// keyframes keeps this value at all times.
    pub fn rest(&self) -> (DVec3, DQuat, DVec3) {
        rest(self.node)
    }
}

fn rest(node: &Node) -> (DVec3, DQuat, DVec3) {
    let rotation = DQuat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    (
        DVec3::from_array(node.scale.unwrap_or([1.0; 3])),
        rotation.normalize(),
        DVec3::from_array(node.translation.unwrap_or([0.0; 3])),
    )
}

/// All nodes of the default scene, depth first: each node comes after its parent, and the children of a node
/// are in the order of the file. Instances, cameras, lights and motion are made from this list. Roots that are
/// children too are shown once, with a notice in `tally`. Fails if the nodes do not form trees, an index is out
/// of range, or a transform is wrong.
pub fn placed<'a>(document: &'a Document, tally: &mut Tally) -> Result<Vec<Placed<'a>>> {
    let parents = parents(document)?;
    let roots = roots(document, &parents, tally)?;
    let mut is_in_scene = descendants(document, &roots);
    roots.iter().for_each(|&root| is_in_scene[root] = true);
    let hidden = visibility::hidden(document, &is_in_scene);
    let mut waiting: Vec<(usize, Option<u32>, DAffine3, bool)> = (roots.into_iter())
        .map(|root| (root, None, DAffine3::IDENTITY, true))
        .collect();
    waiting.reverse();
    let mut placed: Vec<Placed<'_>> = Vec::new();
    // Every node has at most one parent and no root is below another, so this comes to each node at most once.
    while let Some((index, parent, parent_to_world, parent_is_shown)) = waiting.pop() {
        let node = &document.nodes[index];
        let what = || label("node", index, &node.name);
        let in_parent = local_transform(node, what)?;
        let to_world = parent_to_world * in_parent;
        if !to_world.is_finite() {
            return Err(Error::input(format!(
                "{}: its transform is not finite; correct it in the modelling tool",
                what()
            )));
        }
        let children = node.children.iter().rev();
        let own = Some(placed.len() as u32);
        let is_shown = parent_is_shown && !hidden[index];
        waiting.extend(children.map(|&child| (child as usize, own, to_world, is_shown)));
        placed.push(Placed {
            index,
            node,
            parent,
            in_parent,
            to_world,
            is_shown,
        });
    }
    Ok(placed)
}

/// For each node of the document, the index of its parent; `None` for a node without a parent. Fails if a node has two
/// parents, if the nodes form a cycle, or if an index is out of range: transforms could then not be multiplied down the
/// trees.
fn parents(document: &Document) -> Result<Vec<Option<usize>>> {
    let nodes = &document.nodes;
    let mut parents = vec![None; nodes.len()];
    for (index, node) in nodes.iter().enumerate() {
        let what = || label("node", index, &node.name);
        for &child in &node.children {
            let Some(parent) = usize::try_from(child).ok().and_then(|c| parents.get_mut(c)) else {
                return Err(damaged(format!(
                    "{}: child {child} is out of range, there are {} nodes",
                    what(),
                    nodes.len()
                )));
            };
            if let Some(other) = *parent {
                return Err(damaged(format!(
                    "{}: its child, node {child}, is also a child of node {other}",
                    what()
                )));
            }
            *parent = Some(index);
        }
    }
    // Up from every node until where an earlier walk has been: each node is passed once.
    let mut walk = vec![usize::MAX; nodes.len()];
    for start in 0..nodes.len() {
        let mut at = Some(start);
        while let Some(index) = at.filter(|&index| walk[index] == usize::MAX) {
            walk[index] = start;
            at = parents[index];
        }
        if let Some(index) = at.filter(|&index| walk[index] == start) {
            return Err(damaged(format!(
                "{}: is among its own descendants, the nodes form a cycle",
                label("node", index, &nodes[index].name)
            )));
        }
    }
    Ok(parents)
}

/// The indices of the root nodes of the default scene, at which the traversal of its trees starts. If the
/// file names no default scene, its first scene is used; if it has no scenes, the roots are all nodes without
/// a parent. A root that is listed twice, or that is a descendant of another root, is shown once, with a notice
/// in `tally`. Fails if the index of the scene or of a root is out of range.
fn roots(document: &Document, parents: &[Option<usize>], tally: &mut Tally) -> Result<Vec<usize>> {
    let chosen = document.scene.unwrap_or(0);
    let Some(scene) = get(&document.scenes, chosen) else {
        if document.scene.is_some() {
            return Err(damaged(format!(
                "scene {chosen} is out of range, there are {}",
                document.scenes.len()
            )));
        }
        return Ok((0..parents.len())
            .filter(|&index| parents[index].is_none())
            .collect());
    };
    let label_of = |index: usize| label("node", index, &document.nodes[index].name);
    let mut roots = Vec::with_capacity(scene.nodes.len());
    let mut is_listed = vec![false; parents.len()];
    for &root in &scene.nodes {
        let index = usize::try_from(root)
            .ok()
            .filter(|index| *index < parents.len());
        let Some(index) = index else {
            return Err(damaged(format!(
                "scene {chosen}: node {root} is out of range, there are {}",
                parents.len()
            )));
        };
        if std::mem::replace(&mut is_listed[index], true) {
            let text = "nodes that the scene lists twice are shown once";
            tally.add(text, || label_of(index));
        } else {
            roots.push(index);
        }
    }
    if roots.iter().any(|&root| parents[root].is_some()) {
        let is_below = descendants(document, &roots);
        for &root in roots.iter().filter(|&&root| parents[root].is_some()) {
            let text = match is_below[root] {
                true => "roots of the scene that are children too are shown once, as children",
                false => "roots whose parents are outside of the scene are shown without them",
            };
            tally.add(text, || label_of(root));
        }
        roots.retain(|&root| !is_below[root]);
    }
    Ok(roots)
}

/// For each node of the document, true if it is below one of `roots`. The nodes must form trees.
fn descendants(document: &Document, roots: &[usize]) -> Vec<bool> {
    let mut is_below = vec![false; document.nodes.len()];
    let mut waiting = roots.to_vec();
    while let Some(index) = waiting.pop() {
        for &child in &document.nodes[index].children {
            // What is below a node that was met before has been met too, or will be.
            if !std::mem::replace(&mut is_below[child as usize], true) {
                waiting.push(child as usize);
            }
        }
    }
    is_below
}

/// True if a quaternion states a rotation: its length is finite and clearly above 0. It need not be 1, because the caller
/// scales the quaternion to unit length.
pub fn is_rotation(quaternion: DQuat) -> bool {
    let length = quaternion.length();
    length > 1e-6 && length.is_finite()
}

fn local_transform(node: &Node, what: impl Fn() -> String) -> Result<DAffine3> {
    let wrong = |fault: &str| Err(Error::input(format!("{}: {fault}", what())));
    if let Some(matrix) = &node.matrix {
        let matrix = DMat4::from_cols_array(matrix);
        if matrix.row(3) != DVec4::W {
            return wrong("the last row of its matrix is not 0 0 0 1; make it affine");
        }
        return Ok(DAffine3::from_mat4(matrix));
    }
    if node
        .rotation
        .is_some_and(|q| !is_rotation(DQuat::from_array(q)))
    {
        return wrong("its rotation is not a unit quaternion; correct it in the modelling tool");
    }
    let (scale, rotation, translation) = rest(node);
    Ok(DAffine3::from_scale_rotation_translation(
        scale,
        rotation,
        translation,
    ))
}

/// Makes the scene's camera from a camera of the file and from `placed`, the node that refers to it. `index`
/// is the camera's index in the file. The result is `None`, with a notice in `tally`, if the picture would be
/// mirrored, or if the node's transform is singular (a scale of 0, or axes in one plane) and so has no
/// viewing direction. Fails if the field of view, the aspect ratio, or the size of an orthographic picture is wrong.
pub fn camera(
    placed: &Placed,
    index: u64,
    camera: &FileCamera,
    tally: &mut Tally,
) -> Result<Option<Camera>> {
    let name = placed.name_or(&camera.name);
    let what = format!("camera {index} of {}", placed.label());
    let wrong = |fault: String| Err(Error::input(format!("{what}: {fault}")));
    let (projection, aspect_ratio) = match (
        camera.kind.as_str(),
        &camera.perspective,
        &camera.orthographic,
    ) {
        ("perspective", Some(perspective), _) => {
            let fov = perspective.yfov;
            if !(fov > 0.0 && fov < std::f64::consts::PI) {
                return wrong(format!("yfov is {fov}; it must be within 0 and π radians"));
            }
            (Projection::pinhole(fov), perspective.aspect_ratio)
        }
        ("orthographic", _, Some(Orthographic { xmag, ymag })) => {
            for (name, value) in [("xmag", xmag), ("ymag", ymag)] {
                if *value == 0.0 || value.abs() > LARGEST_COORDINATE {
                    return wrong(format!(
                        "{name} is {value:?}; it must be above 0 and at most {LARGEST_COORDINATE:e}"
                    ));
                }
            }
            if *xmag < 0.0 || *ymag < 0.0 {
                let skipped =
                    "cameras with a negative xmag or ymag, which mirrors the picture, are skipped";
                tally.add(skipped, || what);
                return Ok(None);
            }
            let height = 2.0 * ymag;
            (Projection::Orthographic { height }, Some(xmag / ymag))
        }
        _ => {
            return Err(damaged(format!(
                "{what}: is neither perspective nor orthographic"
            )));
        }
    };
    if let Some(aspect) = aspect_ratio
        && !(aspect > 0.0 && aspect.is_finite())
    {
        return wrong(match projection {
            Projection::Perspective { .. } => {
                format!("aspectRatio is {aspect}; it must be positive")
            }
            Projection::Orthographic { .. } => {
                format!("xmag / ymag is {aspect:?}; it must be positive and finite")
            }
        });
    }
    let Some(axes) = rigid(placed.to_world.matrix3) else {
        tally.add(
            "flat cameras (a scale of 0, or axes in one plane) are skipped",
            || what,
        );
        return Ok(None);
    };
    Ok(Some(Camera {
        name,
        camera_to_world: DAffine3::from_mat3_translation(axes, placed.to_world.translation),
        projection,
        aspect_ratio,
    }))
}
