//! A plain `.obj` or `.ply` as a scene: its facets, flat, with a front by their winding, grey; each group of an OBJ a shape of that name.

use etendue_description::{Description, MeshData, NodeId, Value};
use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::sync::Arc;

/// A scene around a mesh file, where it is one.
pub(crate) fn text(path: &Path) -> Option<String> {
    let ending = path.extension()?.to_str()?.to_ascii_lowercase();
    let escaped = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
    let (file, id) = (escaped(path.file_name()?.to_str()?), escaped(path.file_stem()?.to_str()?));
    matches!(ending.as_str(), "obj" | "ply").then(|| {
        format!(
            r#"<scene version="3.0.0"><sensor type="perspective"/><shape type="{ending}" id="{id}"><string name="filename" value="{file}"/>
            <boolean name="face_normals" value="true"/></shape></scene>"#
        )
    })
}

/// Makes a shape of each group of the mesh. Runs of one name are one shape; what has no name keeps that of the file.
pub(crate) fn split(description: &mut Description) {
    let mesh_of = |id: &NodeId| {
        let params = &description.node(*id).params;
        params.iter().position(|p| matches!(p.value.value, Value::Mesh(_))).map(|k| (*id, k))
    };
    let Some((whole, param)) = description.top.iter().find_map(mesh_of) else { return };
    let Value::Mesh(asset) = description.node(whole).params[param].value.value else { return };
    let mesh = Arc::clone(&description.assets.meshes[asset as usize]);
    if mesh.groups.is_empty() {
        return;
    }
    let mut runs: BTreeMap<Option<&str>, Vec<[u32; 3]>> = BTreeMap::new();
    let mut order: Vec<Option<&str>> = Vec::new();
    let (mut at, mut name) = (0, None);
    let end = mesh.indices.len() as u32;
    for (first, next) in mesh.groups.iter().map(|g| (g.first, Some(g.name.as_str()))).chain([(end, None)]) {
        if first > at {
            if !runs.contains_key(&name) {
                order.push(name);
            }
            runs.entry(name).or_default().extend(&mesh.indices[at as usize..first as usize]);
        }
        (at, name) = (first, next);
    }
    let mut top = Vec::new();
    for id in std::mem::take(&mut description.top) {
        if id != whole {
            top.push(id);
            continue;
        }
        for name in &order {
            let part = part(&mesh, runs.get(name).map_or(&[], Vec::as_slice));
            let mut node = description.node(whole).clone();
            if let (Some(name), Some(id)) = (name, &mut node.id) {
                id.value = (*name).to_owned();
            }
            node.params[param].value.value = Value::Mesh(description.assets.meshes.len() as u32);
            description.assets.meshes.push(Arc::new(part));
            top.push(description.add(node));
        }
    }
    description.top = top;
}

/// Some triangles of a mesh with the vertices that they need. Facets are flat here: texture coordinates and normals are of no use.
fn part(mesh: &MeshData, triangles: &[[u32; 3]]) -> MeshData {
    let mut places: HashMap<u32, u32> = HashMap::new();
    let mut part = MeshData { path: mesh.path.clone(), ..MeshData::default() };
    for triangle in triangles {
        let corner = |i: u32| {
            *places.entry(i).or_insert_with(|| {
                part.positions.push(mesh.positions[i as usize]);
                part.positions.len() as u32 - 1
            })
        };
        part.indices.push(triangle.map(corner));
    }
    part
}
