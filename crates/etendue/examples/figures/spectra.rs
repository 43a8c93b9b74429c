//! Three numbers for a spectrum: the Cornell box, whose walls are measured spectra, and a prism.

use crate::Drawn;
use crate::canvas::{Shot, grid};
use etendue::{Image, LoadOptions, Stop};
use std::path::Path;

/// The Cornell box and a prism, each by red, green and blue, and by wavelengths.
pub fn spectra(folder: &Path) -> Drawn {
    let own = std::env::temp_dir().join(format!("etendue-prism-{}", std::process::id()));
    std::fs::create_dir_all(&own)?;
    let file = own.join("prism.xml");
    let drawn = write_prism(&own).and_then(|()| {
        let prism = file.display().to_string();
        Ok(vec![both("cornell-box", "path-mis", 128)?, both(&prism, "bidirectional", 128)?])
    });
    std::fs::remove_dir_all(&own)?;
    grid(&folder.join("spectra.png"), &drawn?, 1.0)
}

fn both(scene: &str, solver: &str, spp: u32) -> Drawn<Vec<Image>> {
    let shot = Shot { scene, solver, parameters: &[], width: 240, stop: Stop::Samples(spp) };
    let square = |spectral| LoadOptions { height: Some(240), spectral: Some(spectral), ..LoadOptions::default() };
    [false, true].map(|spectral| shot.take_with(square(spectral))).into_iter().collect()
}

/// A beam through a prism of dense flint, near the angle of least deviation, onto a screen.
fn write_prism(folder: &Path) -> Drawn {
    let (apex, incidence, n) = (60f64.to_radians(), 63f64.to_radians(), 1.79);
    let turned = |[x, z]: [f64; 2], a: f64| [x * a.cos() - z * a.sin(), x * a.sin() + z * a.cos()];
    let along = |[x, z]: [f64; 2], d: [f64; 2], t: f64| [x + t * d[0], z + t * d[1]];
    let x = (apex / 2.0).tan();
    let beam = turned([(apex / 2.0).cos(), (apex / 2.0).sin()], -incidence).map(|x| -x);
    let deviation = incidence + (n * (apex - (incidence.sin() / n).asin()).sin()).asin() - apex;
    let out = turned(beam, deviation);
    let side = [-out[1], out[0]];
    let target = [x / 2.0, 0.5];
    let lamp = along(target, beam, -3.0);
    let screen = along([-x / 2.0, 0.5], out, 4.5);
    let eye = along(along([0.0, 0.4], out, -3.4), side, 1.8);
    let seen = along(along([0.0, 0.4], out, 2.6), side, 0.2);

    let corners = |y: f64| format!("v {x} {y} 0\nv 0 {y} 1\nv -{x} {y} 0\n");
    let faces = "f 1 4 5\nf 1 5 2\nf 2 5 6\nf 2 6 3\nf 3 6 4\nf 3 4 1\nf 1 2 3\nf 4 6 5\n";
    std::fs::write(folder.join("prism.obj"), format!("{}{}{faces}", corners(-0.6), corners(0.6)))?;
    let at = |[x, z]: [f64; 2], y: f64| format!("{x}, {y}, {z}");
    let text = format!(
        r#"<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="4"/></integrator>
        <sensor type="perspective"><float name="fov" value="38"/>
            <transform name="to_world"><lookat origin="{}" target="{}" up="0, 1, 0"/></transform>
            <film type="hdrfilm"><integer name="width" value="240"/><integer name="height" value="240"/><rfilter type="gaussian"/></film></sensor>
        <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="20"/><translate y="-0.6"/></transform>
            <bsdf type="diffuse"><rgb name="reflectance" value="0.4"/></bsdf></shape>
        <shape type="rectangle"><transform name="to_world"><scale x="1.6" y="0.6"/><lookat origin="{}" target="{}" up="0, 1, 0"/></transform>
            <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.8"/></bsdf></bsdf></shape>
        <shape type="obj"><string name="filename" value="prism.obj"/><boolean name="face_normals" value="true"/>
            <bsdf type="dielectric"><string name="int_ior" value="glass-sf11"/></bsdf></shape>
        <emitter type="spot"><transform name="to_world"><lookat origin="{}" target="{}" up="0, 1, 0"/></transform>
            <rgb name="intensity" value="60"/><float name="cutoff_angle" value="0.9"/><float name="beam_width" value="0.8"/></emitter>
        <emitter type="constant"><rgb name="radiance" value="0.03"/></emitter></scene>"#,
        at(eye, 1.7),
        at(seen, 0.0),
        at(screen, 0.0),
        at(along(screen, out, -1.0), 0.0),
        at(lamp, 0.0),
        at(target, 0.0)
    );
    Ok(std::fs::write(folder.join("prism.xml"), text)?)
}
