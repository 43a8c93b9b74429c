//! What goes into a file comes out of it, and no file whatever brings a reader down.

use etendue_image::{
    Depth, Encoding, ErrorKind, ExrSamples, Format, Image, Layer, Picture, PngDepth, SaveOptions, Transfer, decode, encode, load,
    load_picture, save,
};
use proptest::prelude::*;

/// Pictures of all shapes with light from 2⁻¹⁰ to 2¹⁰, and some zeros.
fn pictures() -> impl Strategy<Value = Image> {
    let channels =
        prop_oneof![Just(&["Y"][..]), Just(&["Y", "A"][..]), Just(&["R", "G", "B"][..]), Just(&["R", "G", "B", "A"][..])];
    (1usize..20, 1usize..37, channels, any::<u32>()).prop_map(|(w, h, channels, seed)| {
        let mut state = seed | 1;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let (stop, zero) = ((state >> 8 & 0xfff) as f32 / 204.8 - 10.0, state >> 28 == 0);
            if zero { 0.0 } else { stop.exp2() }
        };
        let data = (0..w * h * channels.len()).map(|_| next()).collect();
        Image::from_data(w, h, channels, data).unwrap()
    })
}

fn again(image: &Image, format: Format, options: &SaveOptions) -> Image {
    let bytes = encode(&image.clone().into(), format, options).unwrap();
    decode(&bytes, None).unwrap().image
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn float_exr_is_exact(image in pictures()) {
        let back = again(&image, Format::Exr, &SaveOptions::default());
        prop_assert_eq!(back, image);
    }

    #[test]
    fn half_exr_is_within_half_a_step(image in pictures()) {
        let options = SaveOptions { exr: ExrSamples::Half, ..SaveOptions::default() };
        let back = again(&image, Format::Exr, &options);
        prop_assert_eq!(back.encoding().depth, Depth::Half);
        for (a, b) in image.data().iter().zip(back.data()) {
            prop_assert!((a - b).abs() <= a / 2048.0, "{} became {}", a, b);
        }
    }

    #[test]
    fn pfm_is_exact(image in pictures()) {
        let back = again(&image, Format::Pfm, &SaveOptions::default());
        prop_assert_eq!(back.to_rgb(), image.to_rgb());
    }

    #[test]
    fn hdr_is_within_half_a_step(image in pictures()) {
        let back = again(&image, Format::Hdr, &SaveOptions::default());
        for (a, b) in image.to_rgb().pixels().zip(back.pixels()) {
            let step = a[0].max(a[1]).max(a[2]) / 128.0;
            for (a, b) in a.iter().zip(b) {
                prop_assert!((a - b).abs() <= 0.501 * step, "{} became {}", a, b);
            }
        }
    }

    #[test]
    fn png_keeps_code_values(image in pictures(), sixteen: bool) {
        let steps = if sixteen { 65_535.0 } else { 255.0 };
        let png = if sixteen { PngDepth::Sixteen } else { PngDepth::Eight };
        let mut codes = image.with_encoding(Encoding::SRGB);
        codes.data_mut().iter_mut().for_each(|v| *v = (v.min(1.0) * steps).round() / steps);
        let back = again(&codes, Format::Png, &SaveOptions { png, ..SaveOptions::default() });
        prop_assert_eq!(back.data(), codes.data());
        prop_assert_eq!(back.encoding().depth, if sixteen { Depth::Unorm16 } else { Depth::Unorm8 });
        prop_assert_eq!(back.encoding().transfer, Transfer::Srgb);
    }

    #[test]
    fn jpeg_keeps_smooth_pictures(w in 1usize..40, h in 1usize..40, top in 0.1f32..1.0) {
        let data = (0..w * h).flat_map(|i| [top * (i % w) as f32 / 40.0, top * (i / w) as f32 / 40.0, top]).collect();
        let image = Image::rgb(w, h, data).unwrap().with_encoding(Encoding::SRGB);
        let back = again(&image, Format::Jpeg, &SaveOptions::default());
        for (a, b) in image.data().iter().zip(back.data()) {
            prop_assert!((a - b).abs() < 8.0 / 255.0, "{} became {}", a, b);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// Bits flipped, the end cut off: an error or a picture, and nothing else.
    #[test]
    fn broken_files_do_no_harm(image in pictures(), which in 0usize..5, flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6), cut in 0usize..400) {
        let format = [Format::Exr, Format::Png, Format::Jpeg, Format::Hdr, Format::Pfm][which];
        let mut bytes = encode(&image.into(), format, &SaveOptions::default()).unwrap();
        for (i, x) in flips {
            let i = i.index(bytes.len());
            bytes[i] ^= x;
        }
        bytes.truncate(bytes.len().saturating_sub(if cut > 200 { 0 } else { cut }).max(1));
        let _ = decode(&bytes, Some(format));
    }

    /// Headers of the formats that are only read, followed by anything.
    #[test]
    fn random_bytes_do_no_harm(head in 0usize..6, mut bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let heads: [&[u8]; 6] = [
            b"BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\x05\0\0\0\x05\0\0\0\x01\0\x08\0\x01\0\0\0",
            b"BM\0\0\0\0\0\0\0\0\x46\0\0\0\x38\0\0\0\x03\0\0\0\x03\0\0\0\x01\0\x20\0\x03\0\0\0",
            b"\0\0\x0a\0\0\0\0\0\0\0\0\0\x05\0\x05\0\x18\0",
            b"\0\x01\x09\0\0\x10\0\x18\0\0\0\0\x05\0\x05\0\x08\x20",
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 5 +X 9\n",
            b"\xff\xd8\xff\xe0",
        ];
        let mut file = heads[head].to_vec();
        file.append(&mut bytes);
        let _ = decode(&file, Some(Format::Tga));
    }
}

#[test]
fn layers_and_words_survive() {
    let rgb = |v: f32| Image::rgb(3, 2, vec![v; 18]).unwrap();
    let depth = Image::from_data(3, 2, &["Z"], vec![1e5, 2.0, 3.0, 4.0, 5.0, 6.0]).unwrap();
    let picture = Picture {
        image: rgb(0.5),
        layers: vec![
            Layer { name: "albedo".into(), image: rgb(0.25) },
            Layer { name: "depth".into(), image: depth },
            Layer { name: "normal".into(), image: Image::from_data(3, 2, &["X", "Y", "Z"], vec![0.1; 18]).unwrap() },
        ],
        attributes: vec![("scene".into(), "Küche 台所".into()), ("software".into(), "étendue 0.1.0".into())],
    };
    let bytes = encode(&picture, Format::Exr, &SaveOptions::default()).unwrap();
    assert_eq!(decode(&bytes, None).unwrap(), picture);
    assert_eq!(bytes, encode(&picture, Format::Exr, &SaveOptions::default()).unwrap(), "the same bytes each time");
    // Depths and normals stay f32 in a file of halves.
    let half = encode(&picture, Format::Exr, &SaveOptions { exr: ExrSamples::Half, ..SaveOptions::default() }).unwrap();
    let back = decode(&half, None).unwrap();
    assert_eq!(back.layer("depth").unwrap().data()[0], 1e5);
    assert_eq!(back.layer("normal").unwrap().data()[4], 0.1);
    assert_eq!(back.layer("albedo").unwrap().encoding().depth, Depth::Half);

    let png = encode(&picture, Format::Png, &SaveOptions::default()).unwrap();
    assert_eq!(decode(&png, None).unwrap().attribute("scene"), Some("Küche 台所"));
}

#[test]
fn layers_of_another_size_and_double_names_are_refused() {
    let mut picture = Picture::from(Image::new(2, 2, &["R", "G", "B"]).unwrap());
    picture.layers.push(Layer { name: "albedo".into(), image: Image::new(1, 2, &["R", "G", "B"]).unwrap() });
    assert!(encode(&picture, Format::Exr, &SaveOptions::default()).is_err());
    let mut picture = Picture::from(Image::new(2, 2, &["R"]).unwrap());
    picture.attributes = vec![("compression".into(), "zip".into())];
    assert!(encode(&picture, Format::Exr, &SaveOptions::default()).is_err());
}

#[test]
fn files_of_any_name() {
    let folder = tempfile::tempdir().unwrap();
    let image = Image::rgb(2, 2, (0..12).map(|i| i as f32 / 12.0).collect()).unwrap();
    for name in ["a b.exr", "größe.EXR", "画像.pfm", "x.hdr", "y.png", "z.JPG", "z.jpeg"] {
        let path = folder.path().join(name);
        save(&path, &image.clone().into(), &SaveOptions::default()).unwrap();
        let back = load(&path).unwrap().into_linear();
        for (a, b) in image.data().iter().zip(back.data()) {
            assert!((a - b).abs() < 0.1, "{name}: {a} became {b}");
        }
    }
    let e = save(&folder.path().join("a.gif"), &image.clone().into(), &SaveOptions::default()).unwrap_err();
    assert!(matches!(e.kind(), ErrorKind::UnknownEnding) && e.to_string().contains("pfm"), "{e}");
    let e = save(&folder.path().join("no/a.exr"), &image.into(), &SaveOptions::default()).unwrap_err();
    assert!(matches!(e.kind(), ErrorKind::Write(_)) && e.to_string().contains("a.exr"), "{e}");
}

#[test]
fn content_goes_before_the_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("really.png");
    let image = Image::rgb(1, 1, vec![0.25; 3]).unwrap();
    std::fs::write(&path, encode(&image.clone().into(), Format::Exr, &SaveOptions::default()).unwrap()).unwrap();
    assert_eq!(load(&path).unwrap(), image);
    std::fs::write(&path, "<scene version=\"3.0.0\">").unwrap();
    let e = load_picture(&path).unwrap_err().to_string();
    assert!(e.contains("really.png") && e.contains("<scene version") && e.contains("exr, png"), "{e}");
    std::fs::write(&path, "").unwrap();
    assert!(load(&path).unwrap_err().to_string().contains("empty"));
    std::fs::write(&path, b"RIFF\0\0\0\0WEBPVP8 ").unwrap();
    assert!(load(&path).unwrap_err().to_string().contains("WebP"));
    assert!(load(&folder.path().join("none.exr")).unwrap_err().to_string().contains("cannot be read"));
}

#[test]
fn absurd_headers_are_refused_with_their_figures() {
    let pfm = decode(b"PF\n2147483300 2147483300\n-1\n", None).unwrap_err().to_string();
    assert!(pfm.contains("2147483300 x 2147483300"), "{pfm}");
    let hdr = decode(b"#?RADIANCE\n\n-Y 200000 +X 1000\n", None).unwrap_err().to_string();
    assert!(hdr.contains("too soon"), "{hdr}");
    // A sound EXR whose window is then made 16 million pixels wide.
    let mut exr = encode(&Image::rgb(2, 2, vec![0.5; 12]).unwrap().into(), Format::Exr, &SaveOptions::default()).unwrap();
    let at = exr.windows(15).position(|w| w == b"dataWindow\0box2").unwrap() + 10 + 7 + 4;
    exr[at + 8..at + 12].copy_from_slice(&16_000_000i32.to_le_bytes());
    let e = decode(&exr, None).unwrap_err().to_string();
    assert!(e.contains("16000001 x 2"), "{e}");
}

#[test]
fn linear_light_is_encoded_for_png_and_decoded_for_exr() {
    let image = Image::rgb(1, 1, vec![0.18, 7.0, f32::NAN]).unwrap();
    let png = again(&image, Format::Png, &SaveOptions::default());
    assert_eq!(png.data(), [118.0 / 255.0, 1.0, 0.0]);
    let code = Image::rgb(1, 1, vec![0.5, 0.5, 0.5]).unwrap().with_encoding(Encoding::SRGB);
    let exr = again(&code, Format::Exr, &SaveOptions::default());
    assert_eq!(exr.data()[0], etendue_image::srgb_to_linear(0.5));
}
