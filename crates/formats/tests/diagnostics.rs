//! Every class of mistake in a scene's text: the place, the word, the nearest known one.

mod common;

use common::{lines, said, scene, with_files, word};
use etendue_formats::{ReadOptions, read, read_str};

/// The body of a scene in lines of their own, from line 2.
fn body(text: &str) -> Vec<String> {
    said(&format!("<scene version=\"3.0.0\">\n{text}\n</scene>\n"))
}

#[test]
fn xml_quotes() {
    assert_eq!(
        body("<integrator type=\"path\"/>\n  <sensor type=\"thinlens><float name=\"fov\" value=\"3\"/></sensor>"),
        ["s.xml:3:16 error: the value of `type` is missing its closing quote"]
    );
    assert_eq!(
        body("<shape type=\"sphere\"><float name=\"radius value=\"3\"/></shape>"),
        ["s.xml:2:34 error: the value of `name` is missing its closing quote"]
    );
    assert_eq!(
        body("<shape type=\"sphere\"><float name=\"radius\" value=\"3/></shape>"),
        ["s.xml:2:49 error: the value of `value` is missing its closing quote"]
    );
    assert_eq!(body("<shape type=sphere/>"), ["s.xml:2:13 error: the value of `type` must stand in quotes"]);
    assert_eq!(body("<shape type/>"), ["s.xml:2:8 error: attribute `type` has no value | write type=\"...\""]);
    let read = read_str("s.xml", "<scene version=\"3.0.0\"><shape type=\"sphere/></scene>", &ReadOptions::default());
    assert_eq!(word(&read), "\"sphere");
}

#[test]
fn xml_tags() {
    assert_eq!(
        body("<shape type=\"sphere\">\n  <float name=\"radius\" value=\"3\">\n</shape>"),
        ["s.xml:3:3 error: `<float>` is never closed | end the tag with `/>`, or add `</float>`"]
    );
    assert_eq!(
        said("<scene version=\"3.0.0\">\n<shape type=\"sphere\">\n"),
        ["s.xml:2:1 error: `<shape>` is never closed | add `</shape>`, or end the tag with `/>` if nothing belongs inside"]
    );
    assert_eq!(
        body("</bsdf>"),
        ["s.xml:2:1 error: `</bsdf>` closes nothing: no `<bsdf>` is open here | the innermost open element is `<scene>`"]
    );
    assert_eq!(
        body("<shape type=\"sphere\"\n<bsdf type=\"diffuse\"/>"),
        ["s.xml:2:20 error: the tag is not closed: `>` or `/>` is missing"]
    );
    assert_eq!(body("<!-- the end"), ["s.xml:2:1 error: this comment never ends | end it with `-->`"]);
    assert_eq!(said("v 0 0 0\n"), ["s.xml:1:1 error: this is not XML: a tag such as `<scene version=\"3.0.0\">` must come first"]);
    assert_eq!(said(""), ["s.xml:1:1 error: the file holds no XML element | a scene file begins with <scene version=\"3.0.0\">"]);
    assert_eq!(said("<scene version=\"3.0.0\"/><scene/>"), ["s.xml:1:26 error: a second outermost element; a file holds one"]);
    assert_eq!(
        body("<string name=\"a &amp; b\" value=\"&copy;\"/>"),
        [
            "s.xml:2:33 error: `&copy;` is no character reference | a bare `&` is written `&amp;`; known are &lt; &gt; &amp; &quot; &apos; and &#number;",
            "s.xml:2:15 error: `a & b` stands directly in the scene, which has no parameters | did it slip out of an object?",
        ]
    );
    assert_eq!(body("<shape type=\"sphere\" type=\"cube\"/>"), ["s.xml:2:22 error: attribute `type` is given twice"]);
    assert_eq!(
        said("<!DOCTYPE lolz [<!ENTITY a \"b\">]><scene/>"),
        [
            "s.xml:1:1 error: document type definitions are not read | remove the `<!DOCTYPE ...>`; scene files need no entities of their own"
        ]
    );
}

#[test]
fn elements_and_attributes() {
    assert_eq!(body("<shap type=\"sphere\"/>"), ["s.xml:2:2 error: unknown element `<shap>` | did you mean `<shape>`?"]);
    assert_eq!(body("<shape tpye=\"sphere\"/>"), ["s.xml:2:8 error: unknown attribute `tpye` of `<shape>` | did you mean `type`?"]);
    assert_eq!(body("<shape id=\"a\"/>"), ["s.xml:2:2 error: `<shape>` lacks the attribute `type`"]);
    assert_eq!(
        body("<shape type=\"sphere\"><float name=\"radius\" value=\"1\" scale=\"9\"/></shape>"),
        ["s.xml:2:53 error: unknown attribute `scale` of `<float>` | known are: name, value"]
    );
    assert_eq!(
        body("<shape type=\"sphere\"><point name=\"center\" x=\"1\" z=\"2\"/></shape>"),
        ["s.xml:2:23 error: `<point>` lacks the attribute `y`"]
    );
    assert_eq!(body("<translate x=\"1\"/>"), ["s.xml:2:2 error: `<translate>` belongs inside a `<transform>`"]);
    assert_eq!(
        body("<shape type=\"sphere\"><float name=\"a\" value=\"1\"><float name=\"b\" value=\"1\"/></float></shape>"),
        ["s.xml:2:49 error: `<float>` cannot stand inside `<float>` | end `<float>` with `/>`"]
    );
    assert_eq!(
        body("<shape type=\"sphere\"> radius 3 </shape>"),
        ["s.xml:2:23 warning: text inside `<shape>` means nothing | values stand in attributes: value=\"...\""]
    );
    assert_eq!(
        body("<float name=\"radius\" value=\"1\"/>"),
        ["s.xml:2:14 error: `radius` stands directly in the scene, which has no parameters | did it slip out of an object?"]
    );
}

#[test]
fn values() {
    let value = |element: &str| body(&format!("<shape type=\"sphere\">{element}</shape>"));
    assert_eq!(value("<float name=\"a\" value=\"1.5m\"/>"), ["s.xml:2:45 error: `1.5m` is no number"]);
    assert_eq!(
        value("<float name=\"a\" value=\"0,5\"/>"),
        ["s.xml:2:45 error: `0,5` is no number | numbers are written with a point: 0.5"]
    );
    assert_eq!(value("<float name=\"a\" value=\"nan\"/>"), ["s.xml:2:45 error: `nan` is not finite"]);
    assert_eq!(value("<float name=\"a\" value=\"\"/>"), ["s.xml:2:45 error: a number must stand here"]);
    assert_eq!(value("<integer name=\"a\" value=\"1.0\"/>"), ["s.xml:2:47 error: `1.0` is no whole number"]);
    assert_eq!(value("<boolean name=\"a\" value=\"yes\"/>"), ["s.xml:2:47 error: `yes` is no truth value, expected true or false"]);
    assert_eq!(value("<rgb name=\"a\" value=\"1, 2\"/>"), ["s.xml:2:43 error: expected one number or three, found 2"]);
    assert_eq!(value("<rgb name=\"a\" value=\"1, x, 3\"/>"), ["s.xml:2:46 error: `x` is no number"]);
    assert_eq!(value("<rgb name=\"a\" value=\"#ff00\"/>"), ["s.xml:2:43 error: `#ff00` is no colour, expected #rrggbb"]);
    assert_eq!(value("<vector name=\"a\" value=\"1 inf 3\"/>"), ["s.xml:2:48 error: `inf` is not finite"]);
    assert_eq!(
        value("<spectrum name=\"a\" value=\"400:1, 390:2, 500\"/>"),
        ["s.xml:2:55 error: wavelengths must rise: 390 nm follows 400 nm", "s.xml:2:62 error: `500` is no wavelength:value pair"]
    );
    assert_eq!(value("<spectrum name=\"a\" value=\"400:1\"/>"), ["s.xml:2:48 error: a spectrum of pairs has at least two"]);
    assert_eq!(
        value("<spectrum name=\"a\" value=\"1 2\"/>"),
        ["s.xml:2:48 error: 2 numbers are no spectrum | expected one number, or wavelength:value pairs such as 400:0.1, 700:0.2"]
    );
    assert_eq!(
        value("<blackbody name=\"a\" temperature=\"-3\"/>"),
        ["s.xml:2:55 error: a temperature of -3 K, expected more than 0"]
    );
    assert_eq!(
        value("<spectrum type=\"blackbody\" name=\"a\"><float name=\"temprature\" value=\"1\"/></spectrum>"),
        [
            "s.xml:2:38 error: a `blackbody` lacks its `temperature`",
            "s.xml:2:71 error: unknown parameter `temprature` of texture `blackbody` | did you mean `temperature`?"
        ]
    );
    assert_eq!(
        value("<float name=\"a\" value=\"1\"/>\n<string name=\"a\" value=\"x\"/>"),
        ["s.xml:3:15 error: parameter `a` is given twice"]
    );
}

#[test]
fn transforms() {
    let step =
        |element: &str| body(&format!("<shape type=\"cube\"><transform name=\"to_world\">\n{element}\n</transform></shape>"));
    assert_eq!(
        step("<rotat x=\"1\" angle=\"2\"/>"),
        ["s.xml:3:2 error: `<rotat>` is no step of a transform | did you mean `<rotate>`?"]
    );
    assert_eq!(step("<rotate x=\"1\"/>"), ["s.xml:3:2 error: `<rotate>` lacks the attribute `angle`"]);
    assert_eq!(
        step("<rotate angle=\"3\"/>"),
        ["s.xml:3:2 error: the axis of this `<rotate>` is zero | such as <rotate y=\"1\" angle=\"90\"/>"]
    );
    assert_eq!(
        step("<scale x=\"0\"/>"),
        ["s.xml:3:1 error: this `<scale>` flattens space or is not finite | a transform must have an inverse"]
    );
    assert_eq!(step("<matrix value=\"1 2 3\"/>"), ["s.xml:3:16 error: a matrix has 16 numbers, or 9, found 3"]);
    assert_eq!(
        step("<lookat origin=\"0 0 0\" target=\"0,0,0\"/>"),
        ["s.xml:3:2 error: origin and target of this `<lookat>` are the same point"]
    );
    assert_eq!(
        step("<lookat origin=\"0 0 0\" target=\"0 2 0\" up=\"0 1 0\"/>"),
        ["s.xml:3:2 error: `up` of this `<lookat>` points along the line from origin to target | any other direction will do"]
    );
    assert_eq!(step("<lookat origin=\"0 0\" target=\"0 2 0\"/>"), ["s.xml:3:17 error: expected three numbers, found 2"]);
    assert!(step("<rotate x=\"3\" angle=\"2\"/>")[0].contains("warning: the axis of this `<rotate>` has length 3.0000"));
}

#[test]
fn parameters() {
    assert_eq!(
        body("<default name=\"spp\" value=\"4\"/>\n<sampler type=\"$sppp\"/><sampler type=\"$x\"/>"),
        [
            "s.xml:3:39 error: parameter `$x` is not defined here | define it before with <default name=\"x\" value=\"...\"/>, or on the command line with -D x=...",
        ]
    );
    assert_eq!(
        body("<default name=\"spp\" value=\"4\"/>\n<sampler type=\"a $sp\"/>"),
        ["s.xml:3:18 error: parameter `$sp` is not defined here | did you mean `$spp`?"]
    );
    assert_eq!(
        body("<default name=\"r\" value=\"big\"/>\n<shape type=\"sphere\"><float name=\"radius\" value=\"$r\"/></shape>"),
        ["s.xml:3:50 error: `big` is no number | `$r` is `big` here, by <default>"]
    );
    let options = ReadOptions { defines: vec![("sp".into(), "1".into()), ("zzz".into(), "2".into())], ..ReadOptions::default() };
    let text = scene("<default name=\"spp\" value=\"4\"/><integrator type=\"$spp\"/>");
    assert_eq!(
        lines(&read_str("s.xml", &text, &options)),
        [
            "error: `-D sp=1`: the scene has no parameter `sp` | did you mean `spp`?",
            "error: `-D zzz=2`: the scene has no parameter `zzz` | the scene's parameters: spp"
        ]
    );
}

#[test]
fn references() {
    assert_eq!(
        body("<bsdf type=\"diffuse\" id=\"white\"/>\n<shape type=\"cube\"><ref id=\"whit\"/></shape>"),
        ["s.xml:3:29 error: nothing has the id `whit` | did you mean `white`?"]
    );
    let twice = read_str("s.xml", &scene("<bsdf type=\"a\" id=\"w\"/>\n<bsdf type=\"b\" id=\"w\"/>"), &ReadOptions::default());
    assert_eq!(lines(&twice), ["s.xml:2:20 error: the id `w` is given twice"]);
    let label = &twice.1.iter().next().unwrap().labels[0];
    assert_eq!((twice.0.sources.place(label.0).as_str(), label.1.as_str()), ("s.xml:1:43", "first given here"));
    assert_eq!(
        body(
            "<bsdf type=\"twosided\" id=\"a\"><ref id=\"b\"/></bsdf>\n<bsdf type=\"mask\" id=\"b\"><bsdf type=\"bumpmap\"><ref id=\"a\"/></bsdf></bsdf>"
        ),
        ["s.xml:3:56 error: `a` contains itself | `a`, which contains `b`, which contains bsdf `bumpmap`, which contains `a`"]
    );
    assert_eq!(
        body("<bsdf type=\"twosided\" id=\"a\"><ref id=\"a\"/></bsdf>"),
        ["s.xml:2:39 error: `a` contains itself | `a`, which contains `a`"]
    );
    assert_eq!(body("<alias id=\"x\" as=\"y\"/>"), ["s.xml:2:12 error: nothing has the id `x`"]);
    // What stands in a part that could not be read is not missed as well.
    assert_eq!(
        body("<bsdf type=\"diffuse id=\"a\"/>\n<shape type=\"cube\"><ref id=\"a\"/></shape>"),
        ["s.xml:2:12 error: the value of `type` is missing its closing quote"]
    );
}

#[test]
fn a_long_chain_of_references_is_refused() {
    let mut text = String::from("<bsdf type=\"diffuse\" id=\"b0\"/>");
    for i in 1..100_000 {
        text += &format!("<bsdf type=\"twosided\" id=\"b{i}\"><ref id=\"b{}\"/></bsdf>\n", i - 1);
    }
    let said = said(&scene(&text));
    assert_eq!(said, ["s.xml:255:13 error: references lead more than 256 objects deep from here"]);
}

#[test]
fn includes() {
    let options = with_files(&[
        ("a.xml", b"<scene version=\"3.0.0\">\n<include filename=\"b.xml\"/></scene>"),
        ("b.xml", b"<scene version=\"3.0.0\"><include filename=\"sub/../a.xml\"/></scene>"),
        ("c.xml", b"<scene version=\"3.0.0\">\n  <shape type=\"sphere\" color=\"red\"/>\n</scene>"),
        ("old.xml", b"<scene version=\"0.6.0\"><shape type=\"sphere\"/></scene>"),
        ("latin.xml", b"<scene version=\"3.0.0\"><shape type=\"sph\xE4re\"/></scene>"),
    ]);
    let include = |name: &str| read_str("s.xml", &scene(&format!("<include filename=\"{name}\"/>")), &options);
    assert_eq!(
        lines(&include("a.xml")),
        [
            "b.xml:1:43 error: `sub/../a.xml` includes itself | `s.xml`, which includes `a.xml`, which includes `b.xml`, which includes `sub/../a.xml`"
        ]
    );
    assert_eq!(
        lines(&include("aa.xml")),
        ["s.xml:1:43 error: there is no file `aa.xml` | did you mean `a.xml`? | looked in the working folder"]
    );
    let inside = include("c.xml");
    assert!(inside.1.render(&inside.0.sources).contains("= note: included from s.xml:1:43"));
    assert_eq!(lines(&inside), ["c.xml:2:24 error: unknown attribute `color` of `<shape>` | known are: type, id, name"]);
    assert!(lines(&include("old.xml"))[0].starts_with("old.xml:1:17 error: version 0.6.0 is that of Mitsuba 0.5 and 0.6"));
    assert_eq!(
        lines(&include("latin.xml")),
        [
            "s.xml:1:43 error: `latin.xml` cannot be read: it is not UTF-8: byte 0xE4 in line 1, as Latin-1 or Windows files have them; save it as UTF-8"
        ]
    );
}

#[test]
fn versions_and_roots() {
    assert_eq!(said("<scene/>"), ["s.xml:1:2 error: `<scene>` lacks the attribute `version`"]);
    assert_eq!(said("<scene version=\"three\"/>"), ["s.xml:1:17 error: `three` is no version, expected such as 3.0.0"]);
    assert_eq!(said("<scene version=\"4.1\"/>"), ["s.xml:1:17 warning: version 4.1 is not known, read as 3.0.0"]);
    assert_eq!(
        said("<shape version=\"3.0.0\" type=\"sphere\"/>"),
        [
            "s.xml:1:2 error: the outermost element is `<shape>`, expected `<scene>` | a scene file begins with <scene version=\"3.0.0\">"
        ]
    );
    assert_eq!(body("<scene version=\"3.0.0\"/>"), ["s.xml:2:2 error: a `<scene>` cannot stand inside another element"]);
    assert_eq!(
        body("<path value=\"nowhere\"/>"),
        ["s.xml:2:14 error: there is no folder `nowhere` | looked in the working folder"]
    );
}

#[test]
fn files_that_are_no_scenes() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("room.xml"), "<scene version=\"3.0.0\"/>").unwrap();
    let said = |name: &str| {
        lines(&read(&path(name), &ReadOptions::default())).join("\n").replace(&format!("{}", folder.path().display()), "T")
    };
    assert_eq!(said("rom.xml"), "error: `T/rom.xml` cannot be read: there is no such file | did you mean `T/room.xml`?");
    assert_eq!(
        said("a.gltf"),
        "error: `T/a.gltf`: glTF scenes are not read yet | Mitsuba 3 scenes (.xml) and pbrt-v4 scenes (.pbrt) are"
    );
    assert!(
        said("a.ply")
            .starts_with("error: `T/a.ply` is a mesh without a scene around it | name it in a scene: <shape type=\"ply\">")
    );
    assert!(said("a").contains("has no ending"));
    assert!(said("a.zip").contains("files ending in .zip"));
    std::fs::create_dir(path("dir.xml")).unwrap();
    assert_eq!(said("dir.xml"), "error: `T/dir.xml` cannot be read: it is a folder");
}

#[test]
fn very_deep_very_broken() {
    let deep = "<bsdf type=\"twosided\">".repeat(100_000);
    assert_eq!(said(&scene(&deep)), ["s.xml:1:2818 error: elements are nested more than 128 deep"]);
    let quotes = said(&format!("<scene version=\"3.0.0\">{}", "<a b=c>".repeat(1_000_000)));
    assert_eq!(quotes.len(), 51);
    assert!(quotes[50].contains("note: too many mistakes"));
    let attributes = "<scene version=\"3.0.0\"><shape ".to_owned()
        + &(0..100_000).map(|i| format!("a{i}=\"\" ")).collect::<String>()
        + "/></scene>";
    assert_eq!(said(&attributes), ["s.xml:1:469 error: a tag with more than 64 attributes"]);
}

#[test]
fn bombs_are_refused() {
    // Each parameter is twice the one before; each file includes the next one twice.
    let doubling: String = (1..60).map(|i| format!("<default name=\"p{i}\" value=\"$p{}$p{}\"/>", i - 1, i - 1)).collect();
    let said = said(&scene(&format!("<default name=\"p0\" value=\"boom\"/>{doubling}")));
    assert!(said[0].contains("with its parameters put in, this value has more than 1048576 bytes"), "{}", said[0]);

    let names: Vec<String> = (0..40).map(|i| format!("f{i}.xml")).collect();
    let texts: Vec<String> = (1..41).map(|i| scene(&format!("<include filename=\"f{i}.xml\"/>").repeat(2))).collect();
    let mut files: Vec<(&str, &[u8])> = names.iter().zip(&texts).map(|(n, t)| (n.as_str(), t.as_bytes())).collect();
    files.push(("f40.xml", b"<scene version=\"3.0.0\"/>"));
    let said = lines(&read_str("s.xml", &scene("<include filename=\"f0.xml\"/>"), &with_files(&files)));
    assert_eq!(said.len(), 1);
    assert!(said[0].ends_with("error: more than 10000 files are included"), "{}", said[0]);

    // Many unknown names among many known ones.
    let many: String =
        (0..3_000).map(|i| format!("<bsdf type=\"diffuse\" id=\"material{i}\"/><ref id=\"materiel{i}\"/>\n")).collect();
    let said = lines(&read_str("s.xml", &scene(&many), &ReadOptions::default()));
    assert_eq!((said.len(), said.iter().filter(|line| line.contains("did you mean")).count()), (3_000, 50));
}

#[test]
fn a_file_too_large_is_refused_unread() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.xml");
    std::fs::File::create(&path).and_then(|file| file.set_len(1 << 30)).unwrap();
    let said = lines(&read(&path, &ReadOptions::default()));
    assert!(
        said[0].ends_with("cannot be read: it has 1073741824 bytes, more than the 536870912 of the largest text read here"),
        "{}",
        said[0]
    );
}

#[test]
fn all_mistakes_are_told_in_one_go() {
    let text = "<scene version=\"3.0.0\">\r\n<shape type=\"sphere\"><float name=\"r\" value=\"x\"/></shape>\r\n<oops/>\r\n<shape type=\"obj\"><string name=\"filename\" value=\"no.obj\"/></shape>\r\n<shape type=\"cube\"><ref id=\"no\"/></shape>\r\n</scene>";
    let places: Vec<String> = said(text).iter().map(|line| line.split(' ').next().unwrap().to_owned()).collect();
    assert_eq!(places, ["s.xml:2:45", "s.xml:3:2", "s.xml:4:50", "s.xml:5:29"]);
}
