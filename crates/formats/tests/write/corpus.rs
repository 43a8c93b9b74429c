//! Small scenes that hold every model and parameter between them, and the files that they name.

use etendue_image::{ExrSamples, Format, Image, Picture, SaveOptions};

/// The files.
pub fn files() -> Vec<(&'static str, Vec<u8>)> {
    let exr = |w: usize, h: usize| {
        let data = (0..w * h * 3).map(|i| 0.1 + 0.013 * (i * i % 61) as f32).collect();
        let options = SaveOptions { exr: ExrSamples::Float, ..SaveOptions::default() };
        etendue_image::encode(&Picture::from(Image::rgb(w, h, data).unwrap()), Format::Exr, &options).unwrap()
    };
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float u\nproperty float v\n\
               property float r\nproperty float g\nproperty float b\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n\
               0 0 0 0 0 1 0 0\n1 0 0 1 0 0 1 0\n1 1 0.25 1 1 0 0 1\n0 1 0 0 1 1 1 1\n3 0 1 2\n3 0 2 3\n";
    let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.1\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/2\n";
    // A signed distance that changes sign once.
    let mut vol = b"VOL\x03".to_vec();
    [1i32, 2, 2, 2, 1].iter().for_each(|i| vol.extend(i.to_le_bytes()));
    [0f32, 0., 0., 1., 1., 1.].iter().for_each(|x| vol.extend(x.to_le_bytes()));
    [-1f32, -1., -1., -1., 1., 1., 1., 1.].iter().for_each(|x| vol.extend(x.to_le_bytes()));
    vec![
        ("grid.exr", exr(4, 2)),
        ("square.exr", exr(4, 4)),
        ("quad.ply", ply.as_bytes().to_vec()),
        ("quad.obj", obj.as_bytes().to_vec()),
        ("half.vol", vol),
        ("even.bsdf", include_bytes!("../../../../fuzz/corpus/bsdf/spectral.bsdf").to_vec()),
    ]
}

/// Mitsuba's words.
pub const MITSUBA: &str = r#"<scene version="3.0.0">
<integrator type="aov"><string name="aovs" value="d:depth, n:sh_normal"/>
  <integrator type="path"><integer name="max_depth" value="7"/><integer name="rr_depth" value="50"/><boolean name="hide_emitters" value="false"/></integrator>
</integrator>
<sensor type="thinlens" id="eye">
  <float name="fov" value="33.3"/><string name="fov_axis" value="larger"/>
  <float name="aperture_radius" value="0.1"/><float name="focus_distance" value="3.7"/><float name="near_clip" value="0.001"/>
  <float name="principal_point_offset_x" value="0.1"/>
  <transform name="to_world"><lookat origin="1.1 2.2 3.3" target="0 0.1 0" up="0 1 0"/></transform>
  <sampler type="multijitter"><integer name="sample_count" value="16"/><integer name="seed" value="3"/></sampler>
  <film type="hdrfilm"><integer name="width" value="20"/><integer name="height" value="10"/>
    <integer name="crop_offset_x" value="2"/><integer name="crop_width" value="9"/><string name="pixel_format" value="rgba"/>
    <rfilter type="mitchell"><float name="B" value="0.2"/><float name="C" value="0.4"/></rfilter></film>
</sensor>
<sensor type="orthographic"><transform name="to_world"><scale x="2" y="2"/><rotate y="1" angle="33"/><translate z="5"/></transform>
  <film type="hdrfilm"><rfilter type="lanczos"><integer name="lobes" value="2"/></rfilter></film></sensor>
<default name="grey" value="0.3"/>
<texture type="bitmap" id="grid"><string name="filename" value="grid.exr"/><string name="wrap_mode" value="mirror"/>
  <string name="filter_type" value="nearest"/><transform name="to_uv"><scale x="3" y="0.7"/><translate x="0.1" y="0.2"/></transform></texture>
<texture type="checkerboard" id="board"><rgb name="color0" value="0.1 0.2 0.3"/><ref name="color1" id="grid"/>
  <transform name="to_uv"><scale value="4"/></transform></texture>
<bsdf type="diffuse" id="wall"><ref name="reflectance" id="board"/></bsdf>
<bsdf type="twosided" id="grey"><bsdf type="diffuse"><float name="reflectance" value="$grey"/></bsdf></bsdf>
<bsdf type="twosided" id="odd &lt;name&gt; &quot;&amp; größe"><bsdf type="diffuse"><spectrum name="reflectance" value="400:0.1, 500:0.123456789, 700:0.9"/></bsdf><ref id="wall"/></bsdf>
<bsdf type="mask" id="holes"><ref name="opacity" id="grid"/><ref id="grey"/></bsdf>
<bsdf type="blendbsdf" id="blend"><float name="weight" value="0.25"/><ref id="grey"/><bsdf type="roughdielectric"><float name="alpha" value="0.2"/><string name="int_ior" value="diamond"/></bsdf></bsdf>
<shape type="sphere"><float name="radius" value="0.7"/><point name="center" x="1" y="2" z="3"/><ref id="wall"/></shape>
<shape type="sphere"><transform name="to_world"><scale value="0.1"/><rotate x="1" y="2" z="2" angle="40"/><translate x="0.1"/></transform><ref id="grey"/>
  <emitter type="area"><rgb name="radiance" value="1.5, 2.5, 1e-9"/></emitter></shape>
<shape type="rectangle"><boolean name="flip_normals" value="true"/><ref id="odd &lt;name&gt; &quot;&amp; größe"/></shape>
<shape type="rectangle"><emitter type="directionalarea"><float name="radiance" value="2"/></emitter></shape>
<shape type="cube"><ref id="holes"/></shape>
<shape type="disk"><transform name="to_world"><scale x="-1" y="2"/></transform><ref id="blend"/></shape>
<shape type="cylinder"><point name="p0" x="1" y="0" z="0"/><point name="p1" x="1" y="2" z="1"/><float name="radius" value="0.3"/><bsdf type="conductor"><string name="material" value="Cr"/></bsdf></shape>
<shape type="ply"><string name="filename" value="quad.ply"/><bsdf type="diffuse"><texture type="mesh_attribute" name="reflectance"><string name="name" value="vertex_color"/></texture></bsdf></shape>
<shape type="ply"><string name="filename" value="quad.ply"/><boolean name="face_normals" value="true"/><transform name="to_world"><scale x="-1"/></transform><bsdf type="roughconductor"><float name="alpha" value="0.2"/><rgb name="eta" value="0.2 0.9 1.1"/><rgb name="k" value="3.9 2.4 2.1"/></bsdf></shape>
<shape type="obj"><string name="filename" value="quad.obj"/><boolean name="flip_tex_coords" value="false"/><bsdf type="plastic"><rgb name="diffuse_reflectance" value="0.5 0.6 0.1"/></bsdf></shape>
<shape type="sdfgrid"><string name="filename" value="half.vol"/></shape>
<shape type="shapegroup" id="group"><shape type="cube"><bsdf type="principled"><rgb name="base_color" value="0.9 0.5 0.2"/><float name="metallic" value="0.5"/><float name="roughness" value="0.4"/></bsdf></shape><shape type="merge"><shape type="disk"/><shape type="sphere"/></shape></shape>
<shape type="instance"><ref id="group"/><transform name="to_world"><matrix value="1 2 0 1  0 1 0 2  0 0 1 3  0 0 0 1"/></transform></shape>
<shape type="instance"><ref id="group"/></shape>
<shape type="sphere"><bsdf type="dielectric"><float name="int_ior" value="1.6"/><rgb name="specular_transmittance" value="1 0.5 0.5"/></bsdf></shape>
<shape type="sphere"><bsdf type="thindielectric"/></shape>
<shape type="sphere"><bsdf type="roughplastic"><string name="distribution" value="ggx"/><float name="alpha" value="0.15"/><boolean name="nonlinear" value="true"/></bsdf></shape>
<shape type="sphere"><bsdf type="principledthin"><float name="diff_trans" value="0.8"/></bsdf></shape>
<shape type="sphere"><bsdf type="bumpmap"><ref id="board"/><float name="scale" value="2"/><ref id="grey"/></bsdf></shape>
<shape type="sphere"><bsdf type="normalmap"><texture type="bitmap" name="normalmap"><string name="filename" value="grid.exr"/><boolean name="raw" value="true"/></texture><ref id="grey"/></bsdf></shape>
<shape type="sphere"><bsdf type="null"/></shape>
<emitter type="point"><point name="position" x="0.1" y="0.2" z="0.3"/><spectrum name="intensity" value="400:1, 700:2"/></emitter>
<emitter type="spot"><float name="cutoff_angle" value="31"/><float name="intensity" value="5"/><transform name="to_world"><lookat origin="1 2 3" target="0 0 0" up="0 0 1"/></transform></emitter>
<emitter type="directional"><vector name="direction" x="0.1" y="-1" z="0.3"/><spectrum type="blackbody" name="irradiance"><float name="temperature" value="5000"/></spectrum></emitter>
<emitter type="constant"><spectrum name="radiance" value="0.25"/></emitter>
<emitter type="envmap"><string name="filename" value="grid.exr"/><float name="scale" value="0.5"/><transform name="to_world"><rotate y="1" angle="30"/></transform></emitter>
<emitter type="projector"><texture name="irradiance" type="bitmap"><string name="filename" value="grid.exr"/></texture><float name="fov" value="30"/></emitter>
</scene>
"#;

/// pbrt's words: one scene of all shapes, materials, lights and textures, and one for each camera, film, filter, sampler and integrator.
pub fn pbrt_scenes() -> Vec<String> {
    let mut scenes = vec![WORLD.to_owned()];
    let setups = [
        "LookAt 3 4 1.5  .5 .5 0  0 0 1\nCamera \"perspective\" \"float fov\" 45 \"float screenwindow\" [-1 .5 -.4 .6]\nFilm \"rgb\" \"integer xresolution\" 30 \"integer yresolution\" 20 \"integer pixelbounds\" [2 9 3 11]",
        "Scale -1 1 1 LookAt 1 2 3  4 5 6  0 1 0\nCamera \"perspective\" \"float fov\" 30 \"float lensradius\" .1 \"float focaldistance\" 3",
        "Translate 0 1 2\nCamera \"orthographic\" \"float screenwindow\" [-3 3 -2 2]\nFilm \"rgb\" \"integer xresolution\" 30 \"integer yresolution\" 20",
        "Rotate 30 1 2 3\nCamera \"spherical\" \"string mapping\" \"equirectangular\"\nSampler \"halton\" \"integer pixelsamples\" 9 \"integer seed\" 5",
        "Film \"gbuffer\"\nPixelFilter \"box\" \"float xradius\" 1 \"float yradius\" 1\nIntegrator \"simplepath\"",
        "PixelFilter \"gaussian\" \"float sigma\" .7\nIntegrator \"randomwalk\" \"integer maxdepth\" 3",
        "PixelFilter \"mitchell\" \"float B\" .1 \"float C\" .2\nIntegrator \"bdpt\"",
        "PixelFilter \"sinc\" \"float tau\" 2\nIntegrator \"mlt\"",
        "PixelFilter \"triangle\"\nIntegrator \"sppm\" \"integer maxdepth\" 0",
        "Sampler \"stratified\" \"integer xsamples\" 3 \"integer ysamples\" 2\nIntegrator \"lightpath\"",
    ];
    scenes.extend(setups.map(|setup| format!("{setup}\nWorldBegin\nShape \"sphere\"\n")));
    scenes
}

const WORLD: &str = r#"Camera "perspective" "float fov" 40
WorldBegin
LightSource "point" "rgb I" [1 2 3] "point3 from" [.5 1 1.5] "float scale" 2
LightSource "spot" "blackbody I" 3000 "float coneangle" 40 "float conedeltaangle" 10 "point3 from" [1 2 3] "point3 to" [0 0 1]
LightSource "distant" "spectrum L" [400 1 600 3 700 2] "point3 to" [.1 .2 -.9] "float illuminance" 4
LightSource "infinite" "rgb L" [.1 .2 .3]
LightSource "infinite" "string filename" "square.exr" "float scale" .5 "float illuminance" 3
AttributeBegin Rotate 30 0 1 0 Translate 1 2 3
  LightSource "goniometric" "string filename" "square.exr" "rgb I" [1 1 2] "float power" 7
  LightSource "projection" "string filename" "grid.exr" "float fov" 50 "float scale" 3
AttributeEnd
Texture "picture" "spectrum" "imagemap" "string filename" "grid.exr" "float uscale" 2 "float vscale" 3 "float udelta" .1 "float vdelta" .25 "string wrap" "clamp" "string filter" "point"
Texture "adjusted" "float" "imagemap" "string filename" "grid.exr" "string encoding" "linear" "float scale" .5 "bool invert" true
AttributeBegin Translate 1 2 3 Scale 2 2 2
Texture "planar" "spectrum" "imagemap" "string filename" "grid.exr" "string mapping" "planar" "vector3 v1" [1 .5 0] "vector3 v2" [0 .5 1] "float udelta" .5
Texture "solid" "spectrum" "checkerboard" "integer dimension" 3 "rgb tex1" [.1 .2 .3] "rgb tex2" [.3 .2 .1]
Texture "marble" "spectrum" "marble" "float scale" 2 "float variation" .3 "integer octaves" 4
Texture "fbm" "float" "fbm" "integer octaves" 5 "float roughness" .4
Texture "ball" "spectrum" "checkerboard" "string mapping" "spherical"
AttributeEnd
Texture "rough" "float" "imagemap" "string filename" "grid.exr" "string encoding" "gamma 2.2"
Texture "scaled" "spectrum" "scale" "texture tex" "picture" "float scale" .5
Texture "mixed" "spectrum" "mix" "texture tex1" "scaled" "rgb tex2" [.2 .3 .4] "texture amount" "adjusted"
Texture "turned" "spectrum" "directionmix" "rgb tex1" [.2 .3 .4] "rgb tex2" [.5 .6 .7] "vector3 dir" [0 1 2]
Texture "board" "spectrum" "checkerboard" "float uscale" 4 "float vscale" 8 "texture tex1" "turned"
Texture "dots" "spectrum" "dots" "rgb inside" [.2 .3 .4] "rgb outside" [.1 .1 .1]
Texture "corners" "float" "bilerp" "float v00" .1 "float v01" .2 "float v10" .3 "float v11" .4
Texture "wrinkled" "float" "wrinkled"
Texture "windy" "float" "windy"
MakeNamedMaterial "mixed" "string type" "diffuse" "texture reflectance" "mixed" "texture displacement" "fbm"
MakeNamedMaterial "board" "string type" "diffuse" "texture reflectance" "board" "string normalmap" "grid.exr"
MakeNamedMaterial "metal" "string type" "conductor" "float uroughness" .1 "float vroughness" .3 "bool remaproughness" false
MakeNamedMaterial "gold" "string type" "conductor" "spectrum eta" "metal-Au-eta" "spectrum k" "metal-Au-k" "texture roughness" "corners"
MakeNamedMaterial "mirror" "string type" "conductor" "rgb reflectance" [.9 .8 .7]
MakeNamedMaterial "glass" "string type" "dielectric" "float eta" 1.6
MakeNamedMaterial "frosted" "string type" "dielectric" "texture roughness" "rough"
MakeNamedMaterial "prism" "string type" "dielectric" "spectrum eta" "glass-BK7"
MakeNamedMaterial "measured" "string type" "dielectric" "spectrum eta" [400 1.7 700 1.6]
MakeNamedMaterial "hair" "string type" "hair" "float eumelanin" .5 "float beta_m" .2 "texture beta_n" "corners"
MakeNamedMaterial "dyed" "string type" "hair" "rgb reflectance" [.5 .2 .1]
MakeNamedMaterial "pane" "string type" "thindielectric" "float eta" 1.4
MakeNamedMaterial "coated" "string type" "coateddiffuse" "texture reflectance" "dots" "float roughness" .1 "float thickness" .02 "float g" .3 "rgb albedo" [.1 .2 .3] "integer maxdepth" 20 "integer nsamples" 2
MakeNamedMaterial "lacquer" "string type" "coatedconductor" "rgb reflectance" [.5 .6 .7] "float interface.roughness" .01 "float conductor.roughness" .2 "float interface.eta" 1.4
MakeNamedMaterial "leaf" "string type" "diffusetransmission" "rgb reflectance" [.1 .2 .1] "texture transmittance" "marble" "float scale" .9
MakeNamedMaterial "nothing" "string type" "interface"
MakeNamedMaterial "both" "string type" "mix" "string materials" ["mixed" "gold"] "texture amount" "wrinkled"
MakeNamedMaterial "sample" "string type" "measured" "string filename" "even.bsdf"
NamedMaterial "sample" Shape "sphere" "float radius" .3
LightSource "infinite" "rgb L" [1 2 3] "point3 portal" [0 0 9 0 1 9 2 1 9 2 0 9]
NamedMaterial "mixed" Shape "sphere" "float radius" 2 Shape "disk"
NamedMaterial "board" Shape "cylinder" "float radius" .5 "float zmin" -2 "float zmax" 3
NamedMaterial "metal" Shape "sphere" "float zmin" -.5
NamedMaterial "gold" AttributeBegin Translate 1 2 3 Rotate 33 1 2 3 ReverseOrientation Shape "cylinder" AttributeEnd
NamedMaterial "mirror" Shape "disk" "float innerradius" .5
AttributeBegin ReverseOrientation Scale -1 1 1 Shape "sphere" AttributeEnd
NamedMaterial "glass" Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1.1 .33333333] "integer indices" [0 1 2]
NamedMaterial "frosted" Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0] "normal N" [0 0 1 0 .1 1 0 0 2] "point2 uv" [0 0 1 0 .1 1]
NamedMaterial "pane" AttributeBegin Scale -1 1 1 Shape "plymesh" "string filename" "quad.ply" AttributeEnd
NamedMaterial "coated" Shape "bilinearmesh" "point3 P" [0 0 0 1 0 0 0 1 0 1 1 .5] Shape "loopsubdiv" "integer levels" 1 "point3 P" [0 0 0 1 0 0 0 1 0 0 0 1] "integer indices" [0 1 2 0 2 3 0 3 1 1 3 2]
NamedMaterial "lacquer" Shape "curve" "point3 P" [0 0 0 1 0 0 1 1 0 2 2 2] "float width" .1
NamedMaterial "prism" Shape "sphere" NamedMaterial "measured" Shape "sphere"
NamedMaterial "hair" Shape "curve" "point3 P" [0 0 0 1 0 0 1 1 0 2 2 2] "float width" .1 NamedMaterial "dyed" Shape "sphere"
NamedMaterial "leaf" Shape "sphere" "float alpha" .5
NamedMaterial "nothing" Shape "sphere"
NamedMaterial "both" Shape "cylinder" "texture alpha" "windy"
Material "diffuse" "texture reflectance" "solid"
ObjectBegin "thing" Shape "sphere" AttributeBegin Translate 0 0 1 Shape "disk" AttributeEnd ObjectEnd
AttributeBegin Translate 3 0 0 ObjectInstance "thing" AttributeEnd
Material "diffuse" "texture reflectance" "planar"
ObjectInstance "thing"
AttributeBegin AreaLightSource "diffuse" "rgb L" [1 2 3] "bool twosided" true Shape "sphere" AttributeEnd
Material "diffuse" "texture reflectance" "ball"
AttributeBegin AreaLightSource "diffuse" "blackbody L" 4500 "float scale" 3 "float power" 10 Shape "disk" AttributeEnd
AttributeBegin AreaLightSource "diffuse" "string filename" "square.exr" "float scale" 3 Shape "bilinearmesh" "point3 P" [0 0 0 1 0 0 0 1 0 1 1 0] AttributeEnd
"#;
