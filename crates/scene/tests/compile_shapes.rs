//! Shapes and integrators from descriptions: what comes out, and what is said where it does not.

mod common;

use common::document::Document;
use common::{close, close3};
use etendue_description::{GridData, Kind, MeshData, Value};
use etendue_numerics::{Ray, Transform, Vec3};
use etendue_scene::Scene;
use glam::{DMat4, DVec3};
use std::sync::Arc;

fn place(m: DMat4) -> Value {
    Value::Transform(Box::new(Transform::new(m).expect("a map")))
}

fn at(x: f64, y: f64, z: f64) -> Value {
    place(DMat4::from_translation(DVec3::new(x, y, z)))
}

fn depth(scene: &Scene, o: Vec3, d: Vec3) -> Option<f32> {
    scene.intersect(&Ray::new(o, d)).map(|h| h.t)
}

fn says(messages: &str, parts: &[&str]) {
    for part in parts {
        assert!(messages.contains(part), "`{part}` is not in:\n{messages}");
    }
}

#[test]
fn shapes_stand_where_they_are_put() {
    let mut d = Document::default();
    let center = Value::Vector(DVec3::new(0.0, 0.0, 1.0));
    d.top(Kind::Shape, "sphere", &[("center", center), ("radius", Value::Float(0.5)), ("to_world", at(0.0, 1.0, 0.0))]);
    d.top(Kind::Shape, "rectangle", &[("to_world", at(10.0, 0.0, 0.0))]);
    let axis = [("p1", Value::Vector(DVec3::new(0.0, 0.0, 4.0))), ("radius", Value::Integer(2)), ("to_world", at(20.0, 0.0, 0.0))];
    d.top(Kind::Shape, "cylinder", &axis);
    let scene = d.scene();
    assert_eq!((scene.surfaces.len(), scene.triangles), (3, 2));
    assert_eq!(depth(&scene, Vec3::new(0.0, 1.0, 5.0), -Vec3::Z), Some(3.5));
    assert_eq!(depth(&scene, Vec3::new(10.5, 0.5, 5.0), -Vec3::Z), Some(5.0));
    close(depth(&scene, Vec3::new(30.0, 0.0, 3.9), -Vec3::X).expect("a hit"), 8.0, 1e-5);
    close3(scene.bounds.max, Vec3::new(22.0, 2.0, 4.0), 1e-4);
}

#[test]
fn an_instance_shows_its_group_in_several_places() {
    let mut d = Document::default();
    let cube = d.node(Kind::Shape, "cube", &[]);
    let ball = d.node(Kind::Shape, "sphere", &[("to_world", at(0.0, 0.0, 3.0))]);
    let group = d.top(Kind::Shape, "shapegroup", &[("", Value::Node(cube)), ("", Value::Node(ball))]);
    d.top(Kind::Shape, "instance", &[("", Value::Node(group)), ("to_world", at(5.0, 0.0, 0.0))]);
    let large = place(DMat4::from_translation(DVec3::new(-9.0, 0.0, 0.0)) * DMat4::from_scale(DVec3::splat(2.0)));
    d.top(Kind::Shape, "instance", &[("", Value::Node(group)), ("to_world", large)]);
    let scene = d.scene();
    // The group itself is not seen.
    assert_eq!(depth(&scene, Vec3::new(0.0, 0.0, 20.0), -Vec3::Z), None);
    assert_eq!(depth(&scene, Vec3::new(5.0, 0.0, 20.0), -Vec3::Z), Some(16.0));
    assert_eq!(depth(&scene, Vec3::new(-9.0, 0.0, 20.0), -Vec3::Z), Some(12.0));
    let ray = Ray::new(Vec3::new(-9.5, 0.25, -20.0), Vec3::Z);
    let hit = scene.intersect(&ray).expect("a hit");
    let x = scene.interaction(&ray, &hit);
    assert_eq!((x.surface.0, x.instance, x.t), (0, 1, 18.0));
    close3(x.n, -Vec3::Z, 1e-6);
    close3(x.p, Vec3::new(-9.5, 0.25, -2.0), 1e-6);
    assert_eq!((scene.surfaces.len(), scene.instances.len(), scene.triangles), (2, 2, 12));
}

#[test]
fn meshes_and_grids_come_from_the_assets() {
    let mut d = Document::default();
    let mesh = MeshData {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE],
        indices: vec![[0, 1, 2], [1, 3, 2]],
        ..MeshData::default()
    };
    d.assets().meshes.push(Arc::new(mesh));
    let data = (0..8).map(|i| if i < 4 { -0.5 } else { 0.5 }).collect();
    d.assets().grids.push(Arc::new(GridData { size: [2; 3], channels: 1, data, ..GridData::default() }));
    d.top(Kind::Shape, "obj", &[("filename", Value::Mesh(0)), ("face_normals", Value::Bool(true))]);
    d.top(
        Kind::Shape,
        "ply",
        &[("filename", Value::Mesh(0)), ("flip_tex_coords", Value::Bool(true)), ("to_world", at(3.0, 0.0, 0.0))],
    );
    let normals = Value::String("analytic".into());
    d.top(Kind::Shape, "sdfgrid", &[("filename", Value::Grid(0)), ("normals", normals), ("to_world", at(6.0, 0.0, 0.0))]);
    let scene = d.scene();
    let meshes: Vec<_> = scene.surfaces.iter().filter_map(|(_, s)| s.shape.mesh()).collect();
    assert!(meshes[0].normals.is_empty() && meshes[1].normals.len() == 4);
    assert_eq!(depth(&scene, Vec3::new(6.5, 0.5, 5.0), -Vec3::Z), Some(4.5));
}

#[test]
fn mistakes_are_told_at_their_place_all_in_one_go() {
    let mut d = Document::default();
    d.top(Kind::Shape, "spere", &[]);
    d.top(Kind::Shape, "sphere", &[("radius", Value::Float(0.0))]);
    d.top(Kind::Shape, "sphere", &[("radus", Value::Float(1.0))]);
    d.top(Kind::Shape, "linearcurve", &[]);
    let p = Value::Vector(DVec3::ONE);
    d.top(Kind::Shape, "cylinder", &[("p0", p.clone()), ("p1", p)]);
    let projective = DMat4::from_cols_array(&[1., 0., 0., 0.5, 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.]);
    d.top(Kind::Shape, "cube", &[("to_world", place(projective))]);
    d.top(Kind::Shape, "obj", &[]);
    d.top(Kind::Shape, "disk", &[("to_world", place(DMat4::from_scale(DVec3::new(1e-30, 1e-30, 1.0))))]);
    let messages = d.refused();
    says(
        &messages,
        &[
            "scene:1:1: error: unknown shape `spere`",
            "did you mean `sphere`?",
            "scene:3:1: error: this sphere's `radius` is 0",
            "scene:5:1: error: unknown parameter `radus` of shape `sphere`",
            "did you mean `radius`?",
            "scene:6:1: error: shape `linearcurve`: curves cannot be rendered yet",
            "scene:9:1: error: `p0` and `p1` of this cylinder are the same point",
            "scene:11:1: error: `to_world` of a shape has a perspective part",
            "scene:12:1: error: `obj` needs a `filename`",
            "scene:14:1: error: this disk has no area",
        ],
    );
}

#[test]
fn groups_refuse_what_cannot_be_instanced() {
    let mut d = Document::default();
    let emitter = d.node(Kind::Emitter, "area", &[]);
    let lamp = d.node(Kind::Shape, "rectangle", &[("", Value::Node(emitter))]);
    let inner = d.node(Kind::Shape, "shapegroup", &[]);
    let nested = d.node(Kind::Shape, "instance", &[("", Value::Node(inner))]);
    let group = d.top(Kind::Shape, "shapegroup", &[("", Value::Node(lamp)), ("", Value::Node(nested))]);
    d.top(Kind::Shape, "instance", &[("", Value::Node(group))]);
    d.top(Kind::Shape, "instance", &[]);
    d.top(Kind::Shape, "instance", &[("", Value::Node(lamp))]);
    let messages = d.refused();
    says(
        &messages,
        &[
            "scene:3:1: error: a shape of a shape group cannot emit",
            "scene:5:1: error: instances within a shape group",
            "scene:12:1: error: `instance` names no `shapegroup`",
            "scene:14:1: error: `instance` shows a `shapegroup`, not a `rectangle`",
        ],
    );
    // The group is compiled once, however often it is shown.
    assert_eq!(messages.matches("cannot emit").count(), 1, "{messages}");
}

#[test]
fn media_are_refused_once() {
    let mut d = Document::default();
    let medium = d.node(Kind::Medium, "homogeneous", &[]);
    for _ in 0..3 {
        d.top(Kind::Shape, "cube", &[("interior", Value::Node(medium)), ("exterior", Value::Node(medium))]);
    }
    let messages = d.refused();
    says(&messages, &["scene:3:1: error: participating media cannot be rendered yet"]);
    assert_eq!(messages.matches("error").count(), 1, "{messages}");
}

#[test]
fn integrators_become_solvers() {
    let integer = |i| Value::Integer(i);
    let of = |model: &str, params: &[(&str, Value)]| {
        let mut d = Document::default();
        d.top(Kind::Integrator, model, params);
        d.scene().integrator
    };
    let path = of("path", &[("max_depth", integer(4)), ("rr_depth", integer(7)), ("hide_emitters", Value::Bool(true))]);
    assert_eq!((path.solver.as_str(), path.max_depth, path.rr_depth, path.hide_emitters), ("path-mis", Some(4), Some(7), true));
    assert!(path.null_counts);
    let volpath = of("volpath", &[]);
    assert_eq!((volpath.solver.as_str(), volpath.max_depth, volpath.null_counts), ("path-mis", None, false));
    // Who asks for the usual number asks nevertheless.
    assert_eq!((volpath.rr_depth, of("path", &[("rr_depth", integer(5))]).rr_depth), (None, Some(5)));
    for (model, solver) in
        [("volpathmis", "path-mis"), ("prb", "path-mis"), ("prbvolpath", "path-mis"), ("ptracer", "light-nee"), ("depth", "aov")]
    {
        assert_eq!(of(model, &[]).solver, solver, "{model}");
    }
    let direct = of("direct", &[("shading_samples", integer(3))]);
    assert_eq!((direct.solver.as_str(), direct.emitter_samples, direct.bsdf_samples), ("direct", 3, 3));
    let direct = of("direct", &[("emitter_samples", integer(2)), ("bsdf_samples", integer(0))]);
    assert_eq!((direct.emitter_samples, direct.bsdf_samples), (2, 0));

    // The innermost wins; layers are kept.
    let mut d = Document::default();
    let inner = d.node(Kind::Integrator, "direct", &[]);
    let aovs = Value::String("dd:depth, n : sh_normal".into());
    let aov = d.node(Kind::Integrator, "aov", &[("aovs", aovs), ("", Value::Node(inner))]);
    d.top(Kind::Integrator, "moment", &[("", Value::Node(aov))]);
    let integrator = d.scene().integrator;
    assert_eq!(integrator.solver, "direct");
    let layers: Vec<_> = integrator.aovs.iter().map(|(n, q)| (n.as_str(), q.as_str())).collect();
    assert_eq!(layers, [("dd", "depth"), ("n", "sh_normal")]);
}

#[test]
fn integrators_that_are_not_known_are_refused() {
    let mut d = Document::default();
    d.top(Kind::Integrator, "pathh", &[]);
    d.top(Kind::Integrator, "path", &[("max_depth", Value::Integer(-2))]);
    d.top(Kind::Integrator, "aov", &[("aovs", Value::String("a:normals".into()))]);
    d.top(Kind::Integrator, "direct", &[("shading_samples", Value::Integer(1)), ("bsdf_samples", Value::Integer(1))]);
    let messages = d.refused();
    says(
        &messages,
        &[
            "scene:1:1: error: unknown integrator `pathh`",
            "did you mean `path`?",
            "scene:3:1: error: `max_depth` of `path` is -2",
            "scene:5:1: error: unknown quantity `normals` in `aovs`",
            "scene:7:1: error: `shading_samples` stands for both",
            "a scene has one integrator at the most",
        ],
    );
}

#[test]
fn a_black_picture_can_be_explained() {
    let mut d = Document::default();
    d.top(Kind::Shape, "sphere", &[("to_world", at(0.0, 0.0, -5.0))]);
    d.top(Kind::Sensor, "perspective", &[]);
    let reasons = d.scene().diagnose();
    assert!(reasons.iter().any(|r| r.contains("no emitter")), "{reasons:?}");
    assert!(reasons.iter().any(|r| r.contains("behind it")), "{reasons:?}");

    let mut d = Document::default();
    d.top(Kind::Shape, "sphere", &[("radius", Value::Float(3.0))]);
    d.top(Kind::Sensor, "perspective", &[]);
    d.top(Kind::Emitter, "constant", &[]);
    let reasons = d.scene().diagnose();
    assert!(reasons.len() == 1 && reasons[0].contains("inside an object"), "{reasons:?}");

    let mut d = Document::default();
    d.top(Kind::Shape, "sphere", &[("to_world", at(0.0, 0.0, 5.0))]);
    d.top(Kind::Sensor, "perspective", &[]);
    d.top(Kind::Emitter, "constant", &[]);
    assert_eq!(d.scene().diagnose(), Vec::<String>::new());
}
