//! `form-factors`: numbers, files, and what is told.

use crate::Bench;

/// The sides of the unit cube with normals inwards, as quadrilaterals.
const ROOM: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
    f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 3 7 8 4\nf 4 8 5 1\nf 2 6 7 3\n";

/// F between opposite sides of a cube.
const OPPOSITE: f64 = 0.199_825;

#[test]
fn a_plain_mesh_is_enough() {
    let bench = Bench::new();
    bench.write("room.obj", ROOM);
    let closed = ["form-factors", "room.obj", "--samples", "16384", "-o", "f.csv", "-o", "f.mtx", "-o", "f.npz", "-o", "f.json"];
    let said = bench.good(&closed);
    assert!(said.err.contains("repair of a closed scene") && said.err.contains("6 patches"), "{}", said.err);

    // The same numbers in every file.
    let text = String::from_utf8(bench.read("f.csv")).expect("text");
    let rows: Vec<Vec<&str>> = text.lines().skip(1).map(|l| l.split(',').collect()).collect();
    assert_eq!(rows.len(), 30);
    let number = |word: &str| word.parse::<f64>().unwrap_or_else(|_| panic!("{word}"));
    for row in &rows {
        let (from, to): (usize, usize) = (row[0].parse().expect("a number"), row[1].parse().expect("a number"));
        let exact = if from / 2 == to / 2 { OPPOSITE } else { (1.0 - OPPOSITE) / 4.0 };
        assert!((number(row[4]) - exact).abs() < 5.0 * number(row[5]) + 1e-4, "{row:?}");
    }
    let text = String::from_utf8(bench.read("f.mtx")).expect("text");
    let market: Vec<Vec<&str>> = text.lines().skip(2).map(|l| l.split(' ').collect()).collect();
    assert_eq!(market[0], ["6", "6", "30"]);
    for (a, b) in rows.iter().zip(&market[1..]) {
        assert_eq!(number(a[4]), number(b[2]));
        assert_eq!(number(a[0]) + 1.0, number(b[0]));
    }
    let json = bench.json("f.json");
    assert_eq!(json["factors"].as_array().map(Vec::len), Some(30));
    assert!(json["factors"][0][2].as_f64().is_some_and(|f| (f - number(rows[0][4])).abs() < 1e-15));
    assert!(json["repair"]["closure_error_after"].as_f64().is_some_and(|x| x <= 1e-12), "{json}");
    // An archive of arrays that are stored as they are: the numbers lie in the file.
    let npz = bench.read("f.npz");
    assert!(npz.starts_with(b"PK\x03\x04"));
    let first = number(rows[0][4]).to_le_bytes();
    assert!(npz.windows(8).any(|w| w == first) && npz.windows(10).any(|w| w == b"format.npy"));
}

#[test]
fn pairs_of_shapes_are_told_with_their_errors() {
    let bench = Bench::new();
    bench.write(
        "two.xml",
        r#"<scene version="3.0.0"><sensor type="perspective"/>
            <shape type="rectangle" id="floor"><transform name="to_world"><scale value="0.5"/></transform></shape>
            <shape type="rectangle" id="ceiling"><transform name="to_world"><scale value="0.5"/><rotate y="1" angle="180"/>
                <translate z="1"/></transform></shape>
            <shape type="rectangle" id="away"><transform name="to_world"><scale value="0.5"/><translate z="2"/></transform></shape>
        </scene>"#,
    );
    for method in ["hemisphere", "analytic", "area"] {
        let said = bench.good(&["form-factors", "two.xml", "--between", "floor", "ceiling", "--json", "--method", method]);
        let pairs: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
        for pair in pairs.as_array().expect("a list") {
            let (f, error) = (pair["f"].as_f64().expect("a number"), pair["standard_error"].as_f64().expect("a number"));
            let slack = if method == "area" { 2e-4 } else { 1e-6 };
            assert!((f - OPPOSITE).abs() < 4.0 * error + slack, "{method}: {pair}");
        }
    }
    bench.good(&["form-factors", "two.xml", "--between", "floor", "away"]).says(&["face away from each other", "--two-sided"]);
    let both = bench.good(&["form-factors", "two.xml", "--between", "ceiling", "away", "--two-sided"]);
    assert!(!both.err.contains("it is 0") && !both.out.contains(": 0.00000000"), "{}\n{}", both.out, both.err);
    bench.bad(1, &["form-factors", "two.xml", "--between", "flor", "ceiling"]).says(&["no shape is called `flor`", "`floor`"]);
}

/// Groups of a plain OBJ are shapes: the sides of a room by their names, no gap between them.
#[test]
fn groups_are_shapes() {
    let bench = Bench::new();
    let faces: Vec<&str> = ROOM.lines().filter(|l| l.starts_with('f')).collect();
    let vertices: Vec<&str> = ROOM.lines().filter(|l| l.starts_with('v')).collect();
    let text = format!(
        "{}\no floor\n{}\no ceiling\n{}\ng the walls\n{}\n",
        vertices.join("\n"),
        faces[0],
        faces[1],
        faces[2..].join("\n")
    );
    bench.write("room.obj", &text);
    let said = bench.good(&["form-factors", "room.obj", "--method", "analytic", "--between", "floor", "the walls", "--json"]);
    assert!(!said.err.contains("warning"), "{}", said.err);
    let pairs: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    let f = |k: usize| pairs[k]["f"].as_f64().expect("a number");
    assert!((f(0) - (1.0 - OPPOSITE)).abs() < 1e-5 && (f(1) - (1.0 - OPPOSITE) / 4.0).abs() < 1e-5, "{pairs}");
    bench.bad(1, &["form-factors", "room.obj", "--between", "floor", "wals"]).says(&["shapes: floor, ceiling, the walls"]);
}

#[test]
fn what_is_too_large_is_refused_before_it_starts() {
    let bench = Bench::new();
    bench.write("room.obj", ROOM);
    bench
        .bad(1, &["form-factors", "room.obj", "--method", "analytic", "--patches", "60000"])
        .says(&["pairs", "--method hemisphere fits"]);
    bench.bad(1, &["form-factors", "room.obj", "--patch-size", "0.0001"]).says(&["patches", "--patch-size 0.00"]);
    bench.bad(2, &["form-factors", "room.obj", "-o", "f.txt"]).says(&[".json, .csv, .mtx, .npz"]);
    bench.bad(1, &["form-factors", "none.obj"]).says(&["none.obj"]);
}
