use super::*;

fn read(text: &str) -> Result<MeasuredPeople> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("people.csv");
    std::fs::write(&path, text).expect("a file");
    let (people, unusable) = MeasuredPeople::read_usable(&path)?;
    unusable.into_iter().next().map_or(Ok(people), Err)
}

fn refused(text: &str, words: &[&str]) {
    let error = read(text).expect_err(text).to_string();
    for word in words {
        assert!(error.contains(word), "{text:?}: {error}");
    }
}

#[test]
fn millimetres_and_metres_in_any_order_of_columns_are_the_same_people() {
    let people =
        read("subject,sex,mass_kg,stature_m,hip_breadth_mm\n07,male,80.5,1.8,340\n08,,,, \n")
            .expect("two people");
    let anna = people.person("07").expect("a row");
    assert_eq!(anna.stature_m, Some(1.8));
    assert_eq!(anna.mass_kg, Some(80.5));
    assert_eq!(anna.sex, Some(Sex::Male));
    // Hip breadth is the third dimension of the table.
    let mut dimensions = [None; DIMENSIONS];
    dimensions[2] = Some(0.34);
    assert_eq!(anna.dimensions_m, dimensions);
    assert_eq!(people.person("08"), Some(&MeasuredPerson::NOTHING));
    assert_eq!(people.person("09"), None);

    let other = "\u{feff}hip_breadth_m, stature_mm ,subject,sex,mass_kg\r\n0.34,1800,07,male,80.5\r\n,,08,,\r\n";
    assert_eq!(read(other).expect("the same"), people);
}

#[test]
fn what_cannot_be_is_refused_with_its_line() {
    let head = "subject,stature_m,mass_kg,sex,foot_length_mm\n";
    let row = |row: &str| format!("{head}a,1.7,65,female,250\n{row}\n");
    for (text, words) in [
        (row("b,1.7,65,female,25O"), ["people.csv:3", "\"25O\""]),
        (row("b,,,,nan"), ["people.csv:3", "foot_length_mm of nan"]),
        // Mean 246.3 and SD 12.4 mm for women, 271.2 and 13.1 for men: 172 to 321 and
        // 193 to 350.
        (row("b,,,female,340"), ["people.csv:3", "expected 17"]),
        (row("b,,,male,180"), ["people.csv:3", "expected 19"]),
        (row("b,,,,0.25"), ["people.csv:3", "foot_length_mm of 0.25"]),
        (row("b,,,,-250"), ["people.csv:3", "foot_length_mm of -250"]),
        (row("b,0,,,"), ["people.csv:3", "stature_m of 0"]),
        (row("\nb,170,,,"), ["people.csv:4", "stature_m of 170"]),
        (row("b,170,,,"), ["people.csv:3", "stature_m of 170"]),
        (row("b,,1e9,,"), ["people.csv:3", "mass_kg of 1e9"]),
        (row("b,1.9,30,,"), ["people.csv:3", "index of 12 to 60"]),
        (row("b,,,f,"), ["people.csv:3", "female or male"]),
        (row("a,,,,"), ["people.csv:3", "line 2 already"]),
        (row(",1.7,,,"), ["people.csv:3", "a subject"]),
        (row("b,1.7,,"), ["people.csv:3", "5 fields, found 4"]),
        (row("b,\"1,7\",,,"), ["people.csv:3", "\"1,7\""]),
        (head.into(), ["people.csv", "no subjects"]),
        (String::new(), ["people.csv:1", "no column"]),
        ("stature_m\n1.7\n".into(), ["people.csv:1", "\"subject\""]),
        (
            "subject;stature_m\na;1.7\n".into(),
            ["people.csv:1", "separated by commas"],
        ),
        (
            "subject,hip_bredth_mm\na,340\n".into(),
            ["people.csv:1", "hip_breadth, "],
        ),
        (
            "subject,hip_breadth\na,340\n".into(),
            ["people.csv:1", "suffix _mm or _m"],
        ),
        (
            "subject,stature_m,stature_mm\na,1.7,1700\n".into(),
            ["people.csv:1", "each once"],
        ),
    ] {
        refused(&text, &words);
    }
}

#[test]
fn fields_that_cannot_be_are_as_good_as_empty_where_the_rest_is_wanted() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("people.csv");
    let text = "subject,stature_m,mass_kg,sex,foot_length_mm\n\
                a,1.7,65,f,25O\nb,1.6,60,female,240\nc,1.9,30,,\n";
    std::fs::write(&path, text).expect("a file");
    let (people, unusable) = MeasuredPeople::read_usable(&path).expect("three people");
    let said: Vec<String> = unusable.iter().map(ToString::to_string).collect();
    assert_eq!(said.len(), 3, "{said:?}");
    assert!(said[0].contains("people.csv:2: sex: "), "{said:?}");
    assert!(
        said[1].contains("people.csv:2: foot_length_mm: "),
        "{said:?}"
    );
    assert!(said[2].contains("people.csv:4: mass_kg: "), "{said:?}");
    let of = |name| {
        let row = people.person(name).expect("a row");
        (row.stature_m, row.mass_kg, row.sex)
    };
    assert_eq!(of("a"), (Some(1.7), Some(65.0), None));
    assert_eq!(of("b"), (Some(1.6), Some(60.0), Some(Sex::Female)));
    assert_eq!(of("c"), (Some(1.9), None, None));
    // Foot length is empty for a, and 240 mm for b.
    let known = |name| {
        people
            .person(name)
            .map(|row| row.dimensions_m.iter().flatten().count())
    };
    assert_eq!((known("a"), known("b")), (Some(0), Some(1)));
}

#[test]
fn rows_and_walkers_without_each_other_are_named() {
    let people =
        read("subject,knee_height_mm,hip_breadth_mm\n07,480,340\n7,,340\n").expect("two people");
    let warnings = people.warnings(&["07", "08"], false);
    assert_eq!(warnings.len(), 3, "{warnings:?}");
    assert!(warnings[0].contains("\"7\""), "{warnings:?}");
    assert!(warnings[1].contains("measured knee_height"), "{warnings:?}");
    assert!(!warnings[1].contains("hip_breadth"), "{warnings:?}");
    assert!(warnings[2].contains("\"08\" was not"), "{warnings:?}");
    // With a stature the measured knee counts.
    assert_eq!(people.warnings(&["07", "08"], true).len(), 2);
}
