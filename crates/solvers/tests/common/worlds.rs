//! Small scenes that between them hold every kind of light, camera and scattering: what a solver for all scenes is tried on.

use super::*;

/// Pixels of their pictures.
pub const SIZE: [u32; 2] = [8, 8];

pub fn eye() -> String {
    camera("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, SIZE)
}

/// A box with coloured walls, and what stands in it.
pub fn room(camera: &str, walls: &str, inside: &str) -> Scene {
    scene(&format!(r#"{camera}<shape type="cube"><boolean name="flip_normals" value="true"/>{walls}</shape>{inside}"#))
}

pub const WALLS: &str = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.5, 0.3"/></bsdf>"#;

/// A lamp under the ceiling.
pub fn lamp() -> String {
    format!(
        r#"<shape type="rectangle">
            <transform name="to_world"><rotate x="1" angle="90"/><scale x="0.7" z="0.7"/><translate y="0.95"/></transform>
            {}<emitter type="area"><rgb name="radiance" value="3, 4, 5"/></emitter></shape>"#,
        diffuse(0.2)
    )
}

/// A ball in the middle of the room that shines unseen.
pub fn unseen() -> String {
    format!(
        r#"<shape type="sphere"><point name="center" x="-0.2" y="0.3" z="0.1"/><float name="radius" value="0.25"/>{}
            <emitter type="area"><rgb name="radiance" value="3, 4, 5"/><boolean name="unseen" value="true"/></emitter></shape>"#,
        diffuse(0.2)
    )
}

pub const GLASS: &str = r#"<shape type="sphere"><point name="center" x="0.2" y="-0.4" z="0.2"/><float name="radius" value="0.45"/>
    <bsdf type="dielectric"/></shape>"#;
pub const ROUGH_GLASS: &str = r#"<shape type="sphere"><point name="center" x="0.2" y="-0.4" z="0.2"/><float name="radius" value="0.45"/>
    <bsdf type="roughdielectric"><float name="alpha" value="0.4"/></bsdf></shape>"#;
pub const POINT: &str =
    r#"<emitter type="point"><point name="position" x="0.3" y="0.5" z="0"/><rgb name="intensity" value="1, 2, 3"/></emitter>"#;
pub const SPOT: &str = r#"<emitter type="spot"><transform name="to_world"><lookat origin="0, 0.8, 0" target="0.2, -1, 0.3" up="1, 0, 0"/></transform>
    <rgb name="intensity" value="4, 3, 2"/><float name="cutoff_angle" value="35"/></emitter>"#;
pub const SUN: &str = r#"<emitter type="directional"><vector name="direction" x="0.3" y="-1" z="0.4"/><rgb name="irradiance" value="2, 2, 1"/></emitter>"#;
pub const SKY: &str = r#"<emitter type="constant"><rgb name="radiance" value="0.5, 0.7, 1"/></emitter>"#;
/// A bright sky behind a rectangle overhead.
pub const PORTAL: &str = r#"<emitter type="constant"><rgb name="radiance" value="3, 4, 5"/><vector name="portal_corner" x="-1" y="0.8" z="-1"/>
    <vector name="portal_x" x="0" y="0" z="2"/><vector name="portal_y" x="2" y="0" z="0"/></emitter>"#;
pub const MASK: &str = r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/><scale x="0.8" z="0.8"/><translate y="0.3"/></transform>
    <bsdf type="mask"><float name="opacity" value="0.5"/><bsdf type="twosided"><bsdf type="diffuse"/></bsdf></bsdf></shape>"#;

/// A floor with a wall, open to the sky.
pub fn yard(camera: &str, inside: &str) -> Scene {
    scene(&format!(
        r#"{camera}<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="2"/><translate y="-1"/></transform>
            {WALLS}</shape>
        <shape type="rectangle"><transform name="to_world"><rotate y="1" angle="180"/><scale value="2"/><translate z="1.2"/></transform>{}</shape>
        {inside}"#,
        diffuse(0.5)
    ))
}

pub fn lens() -> String {
    camera("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, SIZE).replace(
        r#"type="perspective">"#,
        r#"type="thinlens"><float name="aperture_radius" value="0.1"/><float name="focus_distance" value="1"/>"#,
    )
}

pub fn crop() -> String {
    let film = r#"<rfilter type="box"/><integer name="crop_offset_x" value="3"/><integer name="crop_offset_y" value="8"/>
        <integer name="crop_width" value="8"/><integer name="crop_height" value="4"/>"#;
    camera_with("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, [16, 16], film)
}

pub const ROUGH_METAL: &str = r#"<bsdf type="roughconductor"><float name="alpha" value="0.4"/></bsdf>"#;
pub const PROJECTOR: &str = r#"<emitter type="projector"><transform name="to_world"><lookat origin="0, 0.9, 0" target="0.1, -1, 0.4" up="1, 0, 0"/></transform>
    <float name="fov" value="50"/><float name="scale" value="2"/></emitter>"#;

pub fn parallel() -> String {
    r#"<sensor type="orthographic">
        <transform name="to_world"><scale x="0.9" y="0.9"/><lookat origin="0, 0, -0.95" target="0, -0.2, 1" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/><rfilter type="box"/></film></sensor>"#
        .to_owned()
}

/// Surroundings with a bright side.
pub fn sky_picture() -> String {
    let pixels: Vec<[f32; 3]> = (0..32).map(|i| [0.1 + 2.0 * f32::from(i % 8 == 3), 0.2 + f32::from(i % 5 == 1), 0.3]).collect();
    format!(
        r#"<emitter type="envmap"><string name="filename" value="{}"/></emitter>"#,
        picture_file("bidirectional-sky", 8, &pixels)
    )
}

/// A lamp of a mesh with vertex normals under a map that mirrors it.
pub fn mirrored_lamp() -> String {
    let quad = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvn 0.3 0 1\nvn -0.3 0 1\nf 1//1 2//2 3//2\nf 1//1 3//2 4//1\n";
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bidirectional-quad.obj");
    std::fs::write(&path, quad).expect("the folder for temporary files");
    format!(
        r#"<shape type="obj"><string name="filename" value="{}"/>
            <transform name="to_world"><scale x="-0.7" y="0.7"/><rotate x="1" angle="90"/><translate y="0.9"/></transform>
            {}{}</shape>"#,
        path.display(),
        diffuse(0.5),
        area("3, 4, 5")
    )
}

/// Normals bent far off, by a picture.
pub fn bumps(bsdf: &str) -> String {
    let pixels: Vec<[f32; 3]> = (0..16)
        .map(|i| [0.5 + 0.3 * ((i * 7 % 5) as f32 / 4.0 - 0.5), 0.5 + 0.3 * ((i * 3 % 4) as f32 / 3.0 - 0.5), 0.9])
        .collect();
    let file = picture_file("bidirectional-bumps", 4, &pixels);
    format!(
        r#"<bsdf type="normalmap"><texture type="bitmap" name="normalmap"><boolean name="raw" value="true"/>
            <string name="filename" value="{file}"/></texture>
            {bsdf}</bsdf>"#
    )
}

pub fn all_scenes() -> Vec<(&'static str, Scene)> {
    vec![
        ("glass", room(&eye(), WALLS, &(lamp() + GLASS))),
        ("rough glass", room(&eye(), WALLS, &(lamp() + ROUGH_GLASS))),
        ("points", room(&eye(), WALLS, &format!("{POINT}{SPOT}{}", lamp()))),
        ("distant", yard(&eye(), &format!("{SUN}{SKY}{ROUGH_GLASS}"))),
        ("mask", room(&eye(), WALLS, &(lamp() + MASK))),
        ("lens", room(&lens(), WALLS, &lamp())),
        ("crop", room(&crop(), WALLS, &lamp())),
        ("bumps", room(&eye(), &bumps(ROUGH_METAL), &lamp())),
        ("plastic", room(&eye(), r#"<bsdf type="plastic"/>"#, &lamp())),
        ("parallel", yard(&parallel(), &format!("{SUN}{PROJECTOR}"))),
        ("picture sky", yard(&eye(), &format!("{}{SPOT}", sky_picture()))),
        ("mirrored lamp", room(&eye(), WALLS, &mirrored_lamp())),
        ("portal", yard(&eye(), &format!("{PORTAL}{ROUGH_GLASS}"))),
        ("unseen", room(&eye(), WALLS, &(unseen() + &lamp() + ROUGH_GLASS))),
    ]
}

/// A furnace of albedo 1/2, so flat that nearly every connection is short.
pub fn flat_furnace() -> Scene {
    let camera = camera("0, 0, 0", "1, 0.3, 0", "0, 0, 1", 60.0, [4, 4])
        .replace(r#"<float name="fov""#, r#"<float name="near_clip" value="0.0001"/><float name="fov""#);
    scene(&format!(
        r#"{camera}<shape type="cube"><boolean name="flip_normals" value="true"/>
            <transform name="to_world"><scale z="0.01"/></transform>{}{}</shape>"#,
        diffuse(0.5),
        area("1")
    ))
}

/// A floor on which the edge of a spot's cone crosses the picture.
pub fn cone() -> Scene {
    let floor = r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="2"/></transform><bsdf type="diffuse"/></shape>"#;
    let spot = r#"<emitter type="spot"><transform name="to_world"><lookat origin="0, 1, 0" target="0, 0, 0" up="1, 0, 0"/></transform>
        <rgb name="intensity" value="3"/><float name="cutoff_angle" value="30"/><float name="beam_width" value="29.9"/></emitter>"#;
    // The circle of radius tan 30° crosses the picture.
    scene(&format!("{}{floor}{spot}", camera("0.577, 0.5, 0", "0.577, 0, 0", "0, 0, 1", 20.0, SIZE)))
}
