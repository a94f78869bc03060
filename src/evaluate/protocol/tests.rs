use super::*;

fn take(subject: usize, name: &str) -> SequenceTake {
    SequenceTake {
        subject,
        name: name.into(),
        condition: String::new(),
    }
}

fn refused(text: &str) -> String {
    let parsed = Protocol::parse(Path::new("p.toml"), text);
    parsed.expect_err("makes no sense").to_string()
}

#[test]
fn every_built_in_protocol_has_its_name() {
    for name in NAMES {
        let protocol = Protocol::named(name).expect("built in");
        assert_eq!(protocol.name, name);
        assert!(protocol.description.ends_with('.'), "{name}");
        // A partition is for a tree, and sessions are walks of their own.
        let has_own = [PARTITION, "sessions"].contains(&name);
        assert_eq!(protocol.made.is_empty(), has_own, "{name}");
    }
    let error = Protocol::named("casia-c").expect_err("unknown").to_string();
    assert!(error.contains("closed-set, first-take"), "{error}");
}

/// The protocol of Yu, Tan and Tan 2006, as OpenGait evaluates it.
#[test]
fn casia_b_enrols_four_normal_walks_and_looks_for_three_kinds() {
    let protocol = Protocol::named("casia-b").expect("built in");
    let names = [
        "bg-01", "bg-02", "cl-01", "cl-02", "nm-01", "nm-02", "nm-03", "nm-04", "nm-05", "nm-06",
    ];
    let takes: Vec<SequenceTake> = names.map(|name| take(0, name)).to_vec();
    let roles = protocol.roles(&takes).expect("all are there");
    let chosen = |is_in: &[bool]| -> Vec<&str> {
        let names = names.iter().zip(is_in);
        names
            .filter(|(_, is_in)| **is_in)
            .map(|(name, _)| *name)
            .collect()
    };
    assert_eq!(chosen(&roles.gallery), ["nm-01", "nm-02", "nm-03", "nm-04"]);
    let sets: Vec<_> = protocol
        .probes
        .iter()
        .map(|set| set.name.as_str())
        .collect();
    assert_eq!(sets, ["NM", "BG", "CL"]);
    assert_eq!(chosen(&roles.probes[0]), ["nm-05", "nm-06"]);
    assert_eq!(chosen(&roles.probes[1]), ["bg-01", "bg-02"]);
    assert_eq!(chosen(&roles.probes[2]), ["cl-01", "cl-02"]);
    assert_eq!(protocol.gallery_views, GalleryViews::Each);
    let error = protocol
        .roles(&[take(0, "walk-5kmh")])
        .expect_err("none is there");
    assert!(error.to_string().contains("found walk-5kmh"), "{error}");
}

#[test]
fn the_first_take_of_each_person_enrols_and_the_others_probe() {
    let protocol = Protocol::named("first-take").expect("built in");
    let takes = [take(0, "a"), take(1, "b"), take(0, "c"), take(0, "d")];
    let roles = protocol.roles(&takes).expect("someone has two");
    assert_eq!(roles.gallery, [true, true, false, false]);
    assert_eq!(roles.probes, [[false, false, true, true]]);
    assert!(
        protocol.roles(&takes[..2]).is_err(),
        "nothing is looked for"
    );
}

#[test]
fn the_first_session_enrols_and_other_days_probe() {
    let protocol = Protocol::named("sessions").expect("built in");
    let takes = [
        take(0, "walk-5kmh"),
        take(0, "s2-walk-5kmh"),
        take(1, "s1-a"),
        take(1, "s3-a"),
    ];
    let roles = protocol.roles(&takes).expect("both have two");
    assert_eq!(roles.gallery, [true, false, true, false]);
    assert_eq!(roles.probes, [[false, true, false, true]]);
    let error = protocol.roles(&takes[..1]).expect_err("one session");
    assert!(error.to_string().contains("found walk-5kmh"), "{error}");
}

#[test]
fn cycles_of_made_takes_do_not_overlap() {
    let names = |protocol: &str, cycles| -> Vec<(String, u32)> {
        let made = Protocol::named(protocol).expect("built in").made(cycles);
        let made = made.expect("none is beyond the last");
        made.into_iter()
            .map(|take| (take.take, take.variation))
            .collect()
    };
    let probe = |variation| ("probe".to_owned(), variation);
    assert_eq!(names("closed-set", 2), [probe(1000), probe(1001)]);
    let enrolled = ("enrolled".to_owned(), 0);
    assert_eq!(names("first-take", 2), [enrolled, probe(1000), probe(1001)]);
    for name in NAMES {
        let made = Protocol::named(name).expect("built in").made(1000);
        let made = made.expect("none is beyond the last");
        let mut variations: Vec<u32> = made.iter().map(|take| take.variation).collect();
        variations.sort_unstable();
        variations.dedup();
        assert_eq!(variations.len(), made.len(), "{name}");
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    let head = "name = \"p\"\ndescription = \"d\"\n";
    let nearest = "decision = \"nearest embedding\"\n";
    let probes = "[[probes]]\nname = \"all\"\n";
    assert!(refused(&format!("{head}{nearest}{probes}")).contains("expected a [gallery]"));
    assert!(
        refused(&format!("{head}decision = \"class score\"\nprobes = []\n"))
            .contains("at least one")
    );
    let twice = format!("{head}{nearest}{probes}{probes}[gallery]\n");
    assert!(refused(&twice).contains("\"all\" appears twice"));
    let unknown = format!("{head}{nearest}gallery_view = \"all\"\n{probes}[gallery]\n");
    assert!(refused(&unknown).starts_with("p.toml:4: unknown field"));
}

/// Returns a protocol with the `made` list `made`, in which takes called p or q are probes.
fn made_as(made: &str) -> String {
    format!(
        "name = \"p\"\ndescription = \"d\"\ndecision = \"nearest embedding\"\nmade = [{made}]\n[gallery]\ntakes = [\"g\"]\n[[probes]]\nname = \"all\"\ntakes = [\"p\", \"q\"]\n"
    )
}

#[test]
fn made_takes_never_wrap_nor_reach_what_training_uses() {
    let one =
        |take: &str, variation: u32| format!("{{ take = {take:?}, variation = {variation} }}");
    // 4294967295 + 1 would be 0, which training uses.
    let last = refused(&made_as(&one("p", u32::MAX)));
    assert!(
        last.contains("take \"p\": expected a variation from 0 to 1000000"),
        "{last}"
    );
    assert!(last.ends_with("found 4294967295"), "{last}");
    let trained_on = refused(&made_as(&one("q", 7)));
    assert!(
        trained_on.contains("from 1000 on (which training never uses)"),
        "{trained_on}"
    );
    let twice = refused(&made_as(&[one("g", 1000), one("p", 1000)].join(",")));
    assert!(
        twice.contains("take \"p\" is variation 1000, which take \"g\" has too"),
        "{twice}"
    );

    let parse = |text: &str| Protocol::parse(Path::new("p.toml"), text).expect("it makes sense");
    let near = parse(&made_as(&[one("g", 0), one("p", 999_999)].join(",")));
    assert_eq!(near.made(2).expect("the last two").len(), 3);
    let beyond = near.made(3).unwrap_err().to_string();
    assert!(
        beyond
            .contains("cycle 3 of 3 of take \"p\" is variation 1000001, expected at most 1000000"),
        "{beyond}"
    );
    // With two probe takes, cycles continue at 1016 after 1000 to 1007.
    let meeting = parse(&made_as(&[one("p", 1000), one("q", 1016)].join(",")));
    assert!(meeting.made(8).is_ok());
    let met = meeting.made(9).unwrap_err().to_string();
    assert!(
        met.contains("take \"q\" is variation 1016, which take \"p\" has too"),
        "{met}"
    );
}

#[test]
fn only_the_set_on_which_nothing_acts_is_clean() {
    let clean = |protocol: &Protocol| -> Vec<String> {
        let sets = protocol.probes.iter().filter(|set| set.clean);
        sets.map(|set| set.name.clone()).collect()
    };
    let named = |name| Protocol::named(name).expect("built in");
    assert_eq!(clean(&named("casia-b")), ["NM"]);
    for (conditions, expected) in [
        ("each", "normal"),
        ("casia-b", "NM"),
        ("tum-iitkgp", "regular"),
    ] {
        let list = Conditions::named(conditions).expect("built in").list;
        let under = named("closed-set").under(&list);
        assert_eq!(under.probes.len(), list.len());
        assert_eq!(clean(&under), [expected]);
    }
}

#[test]
fn conditions_that_one_set_pools_are_told() {
    let mut takes = vec![take(0, "a"), take(0, "b"), take(0, "c")];
    let protocol = Protocol::named("closed-set").expect("built in");
    let doubts = |takes: &[SequenceTake]| {
        let roles = protocol.roles(takes).expect("all are probed");
        protocol.doubts(takes, &roles)
    };
    assert_eq!(doubts(&takes), Vec::<String>::new());
    takes[1].condition = "bag".into();
    takes[2].condition = "coat".into();
    takes[0].condition = "normal".into();
    assert!(
        doubts(&takes)[0].starts_with("the probe set all pools 3 conditions (normal, bag, ..)"),
        "{:?}",
        doubts(&takes)
    );
}
