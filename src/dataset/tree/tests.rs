use super::*;
use image::{GrayImage, Luma, Rgb, RgbImage, Rgba, RgbaImage};
use tempfile::TempDir;

fn tree_of(folders: &[&str]) -> TempDir {
    let root = tempfile::tempdir().expect("a folder");
    for folder in folders {
        fs::create_dir_all(root.path().join(folder)).expect("made");
    }
    root
}

/// Draws 8 rows by 10 columns with a bar of two columns, `left` columns from the left.
fn bar(left: u32, grey: u8) -> GrayImage {
    GrayImage::from_fn(10, 8, |x, y| {
        let is_on = (left..left + 2).contains(&x) && (1..7).contains(&y);
        Luma([if is_on { grey } else { 0 }])
    })
}

/// Returns the pickle that NumPy writes of an array with protocol 3.
fn pickled(shape: [u16; 3], bytes: &[u8]) -> Vec<u8> {
    let mut pickle =
        b"\x80\x03cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\0\x85C\x01b\x87R(K\x01"
            .to_vec();
    for size in shape {
        pickle.push(b'M');
        pickle.extend(size.to_le_bytes());
    }
    pickle.extend(b"\x87cnumpy\ndtype\nX\x02\0\0\0u1\x89\x88\x87R(K\x03X\x01\0\0\0|NNNJ\xFF\xFF\xFF\xFFJ\xFF\xFF\xFF\xFFK\0tb\x89B");
    pickle.extend((bytes.len() as u32).to_le_bytes());
    pickle.extend(bytes);
    pickle.extend(b"tb.");
    pickle
}

fn refusal<T>(result: Result<T>, root: &TempDir) -> String {
    let error = result.err().expect("refused").to_string();
    error.replace(&format!("{}/", root.path().display()), "")
}

const SIDE: &str = "001/nm-01/090";

#[test]
fn sequences_are_listed_by_name_without_a_look_at_pictures() {
    let root = tree_of(&[
        "002/nm-01/090",
        "001/nm-02/000",
        SIDE,
        "001/nm-01/045e15",
        ".git/a/b",
    ]);
    fs::write(root.path().join("manifest.csv"), "not looked at").expect("written");
    fs::write(root.path().join(SIDE).join("001.png"), "not looked at").expect("written");
    let tree = Tree::open(root.path(), &TreeLayout::default()).expect("a tree");
    let names: Vec<String> = tree
        .sequences()
        .iter()
        .map(|s| format!("{}/{}/{} {:?}", s.subject, s.take, s.view, s.angles_deg))
        .collect();
    assert_eq!(
        names,
        [
            "001/nm-01/045e15 Some((45.0, 15.0))",
            "001/nm-01/090 Some((90.0, 0.0))",
            "001/nm-02/000 Some((0.0, 0.0))",
            "002/nm-01/090 Some((90.0, 0.0))"
        ]
    );
    assert!(tree.skipped().is_empty() && Tree::is_at(root.path()));
}

#[test]
fn folders_that_are_no_people_are_named_and_views_of_both_kinds_refused() {
    let root = tree_of(&[SIDE, "video/001_nm-01_090/frames"]);
    let tree = Tree::open(root.path(), &TreeLayout::default()).expect("one person");
    assert_eq!(
        (tree.sequences().len(), tree.skipped()),
        (1, &["video".to_owned()][..])
    );

    let root = tree_of(&[SIDE, "001/nm-01/side"]);
    let text = refusal(Tree::open(root.path(), &TreeLayout::default()), &root);
    assert!(
        text.starts_with("001/nm-01/side: expected the name of a view"),
        "{text}"
    );
    let named = TreeLayout {
        named_views: true,
        ..TreeLayout::default()
    };
    bar(1, 255)
        .save(root.path().join(SIDE).join("1.png"))
        .expect("written");
    let tree = Tree::open(root.path(), &named).expect("names");
    assert!(
        tree.sequences()
            .iter()
            .all(|view| view.angles_deg.is_none())
    );
    let root = tree_of(&["001/nm-01"]);
    assert!(
        refusal(Tree::open(root.path(), &TreeLayout::default()), &root)
            .contains("<person>/<take>/<view>/")
    );
    assert!(!Tree::is_at(root.path()));
    assert!(matches!(
        Tree::open("/no/such/tree", &TreeLayout::default()),
        Err(Error::Io { .. })
    ));
}

/// Names of Gait3D, GREW and CCPG as OpenGait prepares them.
#[test]
fn views_that_are_cameras_or_recordings_keep_their_names() {
    let folders = [
        "0002/camid33_videoid2/seq0",
        "0002/camid33_videoid2/seq1",
        "00001/01/79XJefi8",
        "probe/03/etaGVnWf",
        "1_000/U0_D0_BG/00_0",
    ];
    let root = tree_of(&folders);
    for folder in folders {
        let name = folder.rsplit('/').next().expect("a name");
        let pickle = root.path().join(folder).join(format!("{name}.pkl"));
        fs::write(pickle, pickled([1, 8, 10], &bar(1, 255).into_raw())).expect("written");
    }
    let tree = Tree::open(root.path(), &TreeLayout::default()).expect("a tree");
    assert_eq!((tree.sequences().len(), tree.skipped().len()), (5, 0));
    for (at, sequence) in tree.sequences().iter().enumerate() {
        assert_eq!(sequence.angles_deg, None);
        let found = tree.silhouettes(at, Size::S50x30, FramingMode::Height);
        assert_eq!(found.expect("readable").frames, 1);
    }
    // One level too high: there are folders where frames should be.
    let above = tree_of(&["tree/001/nm-01/090"]);
    let text = refusal(Tree::open(above.path(), &TreeLayout::default()), &above);
    assert!(
        text.starts_with("tree/001/nm-01/090: expected frames")
            && text.contains("one level further down"),
        "{text}"
    );
}

#[test]
fn one_of_several_modalities_is_chosen_by_name_or_number() {
    let root = tree_of(&[SIDE]);
    for (name, left) in [("0_heatmap", 1), ("1_sils", 4), ("2_sils-aligned", 8)] {
        let pickle = root.path().join(SIDE).join(format!("{name}.pkl"));
        fs::write(pickle, pickled([1, 8, 10], &bar(left, 255).into_raw())).expect("written");
    }
    let read = |modality: Option<&str>| {
        let layout = TreeLayout {
            modality: modality.map(Modality::parse),
            ..TreeLayout::default()
        };
        let tree = Tree::open(root.path(), &layout).expect("a tree");
        tree.stored(0, Size::S50x30).map(|_| ())
    };
    // All files are found, but none is 50x30; the message shows which one was read.
    for (modality, file) in [
        ("0", "0_heatmap"),
        ("heat", "0_heatmap"),
        ("2", "2_sils-aligned"),
        ("aligned", "2_sils-aligned"),
    ] {
        let text = refusal(read(Some(modality)), &root);
        assert!(
            text.starts_with(&format!("001/nm-01/090/{file}.pkl: expected pictures")),
            "{text}"
        );
    }
    let text = refusal(read(None), &root);
    assert_eq!(
        text,
        "001/nm-01/090: expected one .pkl or .npy and nothing else, found 3 and 0 pictures: 0_heatmap.pkl, 1_sils.pkl, 2_sils-aligned.pkl"
    );
    assert!(refusal(read(Some("sils")), &root).contains("found 2 and 0 pictures: 1_sils.pkl"));
    let text = refusal(read(Some("depth")), &root);
    assert!(
        text.contains("expected files of modality depth, found 0_heatmap.pkl, 1_sils.pkl"),
        "{text}"
    );
    assert!(refusal(read(Some("3")), &root).contains("expected files of modality 3"));
}

#[test]
fn an_npy_file_holds_the_same_masks_as_a_pickle() {
    let root = tree_of(&[SIDE, "001/nm-02/090"]);
    let pixels: Vec<u8> = [bar(1, 255), bar(4, 255)]
        .into_iter()
        .flat_map(GrayImage::into_raw)
        .collect();
    fs::write(
        root.path().join(SIDE).join("1.pkl"),
        pickled([2, 8, 10], &pixels),
    )
    .expect("written");
    let array = root.path().join("001/nm-02/090/1.npy");
    let npy = |descr: &str, bytes: Vec<u8>| {
        let mut file = crate::dataset::npy::npy_header(descr, &[2, 8, 10]);
        file.extend(bytes);
        fs::write(&array, file).expect("written");
    };
    let read = |index| {
        let tree = Tree::open(root.path(), &TreeLayout::default()).expect("a tree");
        if index == 1 {
            assert_eq!(tree.frames(1).expect("a file"), Some(2));
        }
        tree.silhouettes(index, Size::S50x30, FramingMode::Height)
    };
    let expected = read(0).expect("masks");
    let bools: Vec<u8> = pixels.iter().map(|pixel| pixel / 255).collect();
    npy("|b1", bools.clone());
    assert_eq!(read(1).expect("masks"), expected);
    npy(
        "<f4",
        bools
            .iter()
            .flat_map(|on| f32::from(*on).to_le_bytes())
            .collect(),
    );
    assert_eq!(read(1).expect("masks"), expected);
    npy("|u1", pixels[1..].to_vec());
    assert_eq!(
        refusal(read(1), &root),
        "001/nm-02/090/1.npy: the file ends 1 bytes too early (was it copied whole?)"
    );
    npy(">f4", vec![0; 640]);
    assert!(refusal(read(1), &root).contains("float32 or float64, found >f4"));
}

#[test]
fn sizes_are_found_out_by_the_beginnings_of_files() {
    let root = tree_of(&[SIDE, "001/nm-02/090", "001/nm-03/090"]);
    let at = |name: &str| root.path().join("001").join(name);
    fs::write(
        at("nm-01/090/090.pkl"),
        pickled([300, 64, 64], &[7; 300 * 64 * 64]),
    )
    .expect("written");
    bar(1, 255).save(at("nm-02/090/1.png")).expect("written");
    GrayImage::new(44, 64)
        .save(at("nm-03/090/1.png"))
        .expect("written");
    let tree = Tree::open(root.path(), &TreeLayout::default()).expect("a tree");
    let check = |number, stored| tree.check_size(number, stored);
    for stored in [&[][..], &[Size::S64x64], &[Size::S64x44, Size::S64x64]] {
        check(0, stored).expect("64x64, which is cut to 64x44");
    }
    check(1, &[]).expect("any size, if all have it");
    check(2, &[Size::S64x44]).expect("64x44");
    let text = refusal(check(1, &[Size::S64x44]), &root);
    assert!(
        text.starts_with("001/nm-02/090: expected pictures of 64x44")
            && text.ends_with("found 8x10"),
        "{text}"
    );
    GrayImage::new(11, 8)
        .save(at("nm-02/090/2.png"))
        .expect("written");
    let text = refusal(check(1, &[]), &root);
    assert_eq!(
        text,
        "001/nm-02/090/2.png: expected 8x10 pixels as in the frames before, found 8x11"
    );
}

#[test]
fn frames_are_read_in_order_and_empty_ones_counted() {
    let root = tree_of(&[SIDE]);
    let at = |name: &str| root.path().join(SIDE).join(name);
    bar(1, 128).save(at("001.png")).expect("written");
    bar(1, 127).save(at("002.png")).expect("written");
    // Half as high, so that it becomes twice as wide.
    let flat = GrayImage::from_fn(10, 8, |x, y| Luma([u8::from(x > 7 && y > 4) * 255]));
    flat.save(at("003.png")).expect("written");
    fs::write(at("gei.png"), "passed over").expect("written");
    let tree = Tree::open(root.path(), &TreeLayout::default()).expect("a tree");

    let found = tree
        .silhouettes(0, Size::S50x30, FramingMode::Height)
        .expect("readable");
    assert_eq!((found.frames, found.empty), (2, 1));
    assert_eq!(found.pixels.len(), 2 * 1500);
    let width = |frame: usize| {
        let row = &found.pixels[frame * 1500..frame * 1500 + 30];
        row.iter().filter(|pixel| **pixel == 255).count()
    };
    // 2 columns scaled by 50 / 6 hold 16 samples; scaled by 50 / 3 they hold 34, of which 30 stay.
    assert_eq!((width(0), width(1)), (16, 30));
    assert!((found.clipped_share - 0.5 * 4.0 / 34.0).abs() < 1e-12);
    let error = tree.silhouettes(0, Size::S50x30, FramingMode::Camera);
    assert!(refusal(error, &root).contains("use height or box"));
}

#[test]
fn a_pickle_holds_what_its_pictures_would() {
    let (pngs, pickles) = (tree_of(&[SIDE]), tree_of(&[SIDE]));
    let mut bytes = Vec::new();
    for (index, left) in [1, 4, 8].into_iter().enumerate() {
        let picture = bar(left, 255);
        picture
            .save(pngs.path().join(SIDE).join(format!("{index}.png")))
            .expect("written");
        bytes.extend(picture.into_raw());
    }
    let pickle = pickles.path().join(SIDE).join("090.pkl");
    fs::write(pickle, pickled([3, 8, 10], &bytes)).expect("written");
    let [a, b] = [&pngs, &pickles].map(|root| {
        let tree = Tree::open(root.path(), &TreeLayout::default()).expect("a tree");
        tree.silhouettes(0, Size::S64x64, FramingMode::Height)
            .expect("readable")
    });
    assert_eq!(a, b);
    assert_eq!(a.frames, 3);
}

#[test]
fn stored_silhouettes_are_cut_as_opengait_cuts_them() {
    let root = tree_of(&[SIDE]);
    let bytes: Vec<u8> = (0..2 * 64 * 64).map(|i| (i % 64) as u8).collect();
    let pickle = root.path().join(SIDE).join("090.pkl");
    fs::write(pickle, pickled([2, 64, 64], &bytes)).expect("written");
    let tree = Tree::open(root.path(), &TreeLayout::default()).expect("a tree");
    let whole = tree.stored(0, Size::S64x64).expect("64x64");
    assert_eq!((whole.frames, whole.pixels), (2, bytes));
    let cut = tree.stored(0, Size::S64x44).expect("64x44");
    assert_eq!((cut.frames, cut.pixels.len()), (2, 2 * 64 * 44));
    let row: Vec<u8> = (10..54).collect();
    assert!(cut.pixels.chunks_exact(44).all(|found| found == row));
    let text = refusal(tree.stored(0, Size::S50x30), &root);
    assert!(
        text.contains("expected pictures of 50x30") && text.ends_with("found 64x64"),
        "{text}"
    );
}

#[test]
fn files_that_cannot_be_used_are_named() {
    let text_of = |files: &[(&str, &[u8])]| {
        let root = tree_of(&[SIDE]);
        for (name, content) in files {
            fs::write(root.path().join(SIDE).join(name), content).expect("written");
        }
        let tree = Tree::open(root.path(), &TreeLayout::default()).expect("a tree");
        refusal(
            tree.silhouettes(0, Size::S50x30, FramingMode::Height),
            &root,
        )
    };
    let png = |picture: &GrayImage| crate::report::png(picture).expect("a PNG");
    let whole = png(&bar(1, 255));
    let array = pickled([1, 8, 10], &bar(1, 255).into_raw());

    assert!(text_of(&[]).starts_with("001/nm-01/090: expected frames as .png"));
    let text = text_of(&[("1.png", &whole), ("2.png", b"not a picture")]);
    assert!(
        text.starts_with("001/nm-01/090/2.png: cannot be read as PNG"),
        "{text}"
    );
    let text = text_of(&[("1.png", &whole[..whole.len() / 2])]);
    assert!(
        text.starts_with("001/nm-01/090/1.png: cannot be read as PNG"),
        "{text}"
    );
    let text = text_of(&[("1.png", &png(&GrayImage::new(4097, 1)))]);
    assert!(
        text.starts_with("001/nm-01/090/1.png: cannot be read as PNG"),
        "{text}"
    );
    assert!(text_of(&[("1.bmp", &whole)]).contains("1.bmp: expected frames as .png"));
    assert!(text_of(&[("1.jpg", &whole)]).contains("1.jpg: cannot be read as JPEG"));
    let text = text_of(&[("1.jpg", &whole), ("2.png", &whole)]);
    assert!(text.contains("found 1 .png and 1 .jpg"), "{text}");
    assert!(text_of(&[("a.pkl", &array), ("b.pkl", &array)]).contains("found 2 and 0 pictures"));
    assert!(text_of(&[("a.pkl", &array), ("1.png", &whole)]).contains("found 1 and 1 pictures"));
    let text = text_of(&[("a.pkl", &array[..array.len() - 9])]);
    assert!(
        text.contains(&format!(
            "a.pkl at byte {}: the pickle is cut short",
            array.len() - 88
        )),
        "{text}"
    );
    let text = text_of(&[("a.pkl", &pickled([0, 8, 10], &[]))]);
    assert!(
        text.contains("expected an array of 1 to 10000 frames"),
        "{text}"
    );
}

#[test]
fn a_picture_with_transparency_is_refused() {
    let root = tree_of(&[SIDE]);
    let picture = RgbaImage::from_pixel(4, 4, Rgba([255, 255, 255, 0]));
    picture
        .save(root.path().join(SIDE).join("1.png"))
        .expect("written");
    let tree = Tree::open(root.path(), &TreeLayout::default()).expect("a tree");
    let error = tree.silhouettes(0, Size::S50x30, FramingMode::Height);
    assert!(refusal(error, &root).contains("found one with transparency"));
}

#[test]
fn pictures_in_colour_and_of_several_sizes_are_refused() {
    let root = tree_of(&[SIDE]);
    let folder = root.path().join(SIDE);
    let grey = RgbImage::from_pixel(4, 4, Rgb([200; 3]));
    grey.save(folder.join("1.png")).expect("written");
    fs::write(folder.join("Thumbs.db"), "of another program").expect("written");
    let tree = Tree::open(root.path(), &TreeLayout::default()).expect("a tree");
    let read = || tree.silhouettes(0, Size::S50x30, FramingMode::Height);
    assert_eq!(read().expect("grey in three channels").frames, 1);
    let colour = RgbImage::from_pixel(4, 4, Rgb([200, 200, 10]));
    colour.save(folder.join("2.png")).expect("written");
    assert!(refusal(read(), &root).contains("found a picture in colour"));
    let wide = RgbImage::from_pixel(6, 4, Rgb([200; 3]));
    wide.save(folder.join("2.png")).expect("written");
    let text = refusal(read(), &root);
    assert!(
        text.contains("expected 4x4 pixels as in the frames before, found 4x6"),
        "{text}"
    );
}

/// Checks that the walkers of a sequence of a tree are centred and fill all rows.
fn check_framing(tree: &Tree, at: usize) {
    let found = tree.silhouettes(at, Size::S64x64, FramingMode::Height);
    let found = found.expect("readable");
    assert_eq!(found.empty, 0);
    for frame in found.pixels.chunks_exact(64 * 64) {
        let row_is_on = |row: usize| frame[row * 64..(row + 1) * 64].contains(&255);
        assert!(row_is_on(0) && row_is_on(63));
        let on = frame.iter().enumerate().filter(|(_, pixel)| **pixel == 255);
        let (count, sum) = on.fold((0, 0), |(n, sum), (at, _)| (n + 1, sum + 2 * (at % 64) + 1));
        // Within half a column of the middle, the upper half included: |mean - 32| <= 1/2.
        let off = sum as f64 / f64::from(2 * count) - 32.0;
        assert!((-0.5..=0.5).contains(&off), "{off}");
    }
}

/// Two people, two takes each, from the left, rendered by another program from skinned meshes.
#[test]
fn walkers_of_a_tree_that_others_made_are_framed() {
    let tree = Tree::open("tests/data/people/people", &TreeLayout::default()).expect("a tree");
    let sequences = tree.sequences();
    assert_eq!((sequences.len(), tree.skipped()), (4, &[][..]));
    for (at, sequence) in sequences.iter().enumerate() {
        assert_eq!(sequence.view, "090");
        check_framing(&tree, at);
    }
}

mod with_data {
    use super::*;

    /// 10 people, 29 takes, 10 views.
    #[test]
    #[ignore = "needs EDGEGAIT_DATA"]
    fn a_large_tree_is_listed_and_its_walkers_framed() {
        let data = std::env::var_os("EDGEGAIT_DATA").expect("EDGEGAIT_DATA");
        let tree =
            Tree::open(Path::new(&data).join("reallike"), &TreeLayout::default()).expect("a tree");
        assert_eq!(
            (tree.sequences().len(), tree.skipped()),
            (290, &["video".to_owned()][..])
        );
        let mut sequences = tree.sequences().iter();
        let side = sequences.position(|sequence| sequence.view == "090");
        check_framing(&tree, side.expect("a side view"));
    }
}
