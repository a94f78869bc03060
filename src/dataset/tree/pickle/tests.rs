use super::*;

/// `numpy.arange(24, dtype=numpy.uint8).reshape(2, 3, 4)`, pickled by NumPy 2.x with
/// protocols 2 to 5, and by NumPy 1.x with protocol 3 and no memo.
const PICKLES: [&str; 5] = [
    "8002636e756d70792e5f636f72652e6d756c746961727261790a5f7265636f6e7374727563740a7100636e756d70790a6e6461727261790a71014b00857102635f636f646563730a656e636f64650a7103580100000062710458060000006c6174696e317105867106527107877108527109284b014b024b034b0487710a636e756d70790a64747970650a710b58020000007531710c898887710d52710e284b0358010000007c710f4e4e4e4affffffff4affffffff4b00747110628968035818000000000102030405060708090a0b0c0d0e0f101112131415161771116805867112527113747114622e",
    "8003636e756d70792e5f636f72652e6d756c746961727261790a5f7265636f6e7374727563740a7100636e756d70790a6e6461727261790a71014b008571024301627103877104527105284b014b024b034b04877106636e756d70790a64747970650a7107580200000075317108898887710952710a284b0358010000007c710b4e4e4e4affffffff4affffffff4b0074710c62894318000102030405060708090a0b0c0d0e0f1011121314151617710d74710e622e",
    "800495a5000000000000008c166e756d70792e5f636f72652e6d756c74696172726179948c0c5f7265636f6e7374727563749493948c056e756d7079948c076e6461727261799493944b0085944301629487945294284b014b024b034b04879468038c0564747970659493948c02753194898887945294284b038c017c944e4e4e4affffffff4affffffff4b00749462894318000102030405060708090a0b0c0d0e0f1011121314151617947494622e",
    "80059590000000000000008c136e756d70792e5f636f72652e6e756d65726963948c0b5f66726f6d62756666657294939428961800000000000000000102030405060708090a0b0c0d0e0f1011121314151617948c056e756d7079948c0564747970659493948c02753194898887945294284b038c017c944e4e4e4affffffff4affffffff4b007494624b024b034b0487948c014394749452942e",
    "8003636e756d70792e636f72652e6d756c746961727261790a5f7265636f6e7374727563740a636e756d70790a6e6461727261790a4b00854301628752284b014b024b034b0487636e756d70790a64747970650a5802000000753189888752284b0358010000007c4e4e4e4affffffff4affffffff4b007462894218000000000102030405060708090a0b0c0d0e0f101112131415161774622e",
];

fn bytes(hex: &str) -> Vec<u8> {
    let byte = |at| u8::from_str_radix(&hex[at..at + 2], 16).expect("hexadecimal");
    (0..hex.len()).step_by(2).map(byte).collect()
}

fn refusal(pickle: &[u8]) -> RefusedPickle {
    read(pickle).expect_err("refused")
}

#[test]
fn arrays_are_read_as_every_protocol_has_them() {
    let expected: Vec<u8> = (0..24).collect();
    for pickle in PICKLES {
        let pickle = bytes(pickle);
        let array = read(&pickle).expect("NumPy's own");
        assert_eq!(array.shape, [2, 3, 4]);
        assert_eq!(*array.bytes, expected);
    }
}

/// The written bytes equal those of NumPy 1.x with protocol 3 and no memo, and sides above 255 can
/// be read back.
#[test]
fn arrays_are_written_as_numpy_has_them() {
    let written = pickled([2, 3, 4], &(0..24).collect::<Vec<u8>>());
    assert_eq!(written, bytes(PICKLES[4]));
    // 300 takes more than a byte.
    let many = vec![9; 300 * 2];
    let array = pickled([300, 2, 1], &many);
    let array = read(&array).expect("our own");
    assert_eq!(array.shape, [300, 2, 1]);
    assert_eq!(*array.bytes, many);
    assert_eq!(
        shape(&pickled([300, 2, 1], &many)[..200]),
        Some([300, 2, 1])
    );
    assert_eq!(shape(b"no pickle"), None);
}

#[test]
fn bytes_above_127_survive_protocol_2() {
    // The last byte, 0x17, becomes U+00FF, which is two bytes of UTF-8, so the count grows by one.
    let mut pickle = bytes(PICKLES[0]);
    let at = pickle
        .windows(2)
        .position(|pair| pair == [0x16, 0x17])
        .expect("there")
        + 1;
    pickle.splice(at..=at, "\u{FF}".bytes());
    let count = pickle
        .windows(5)
        .position(|five| five == [b'X', 24, 0, 0, 0])
        .expect("there");
    pickle[count + 1] = 25;
    assert_eq!(read(&pickle).expect("Latin-1").bytes[22..], [0x16, 0xFF]);
}

#[test]
fn a_pickle_that_would_run_something_is_refused_by_name() {
    let refused = refusal(b"\x80\x03cposix\nsystem\nX\x02\0\0\0ls\x85R.");
    assert_eq!(
        (refused.byte, refused.problem.as_str()),
        (
            2,
            "expected one NumPy array, or a list of them, found \"posix\" \"system\", which is never run"
        )
    );
    // STACK_GLOBAL, INST, EXT1 and a dictionary.
    assert!(
        refusal(b"\x80\x04\x8c\x02os\x8c\x06system\x93.")
            .problem
            .contains("never run")
    );
    for other in [
        &b"\x80\x02(ios\nsystem\n."[..],
        b"\x80\x02\x82\x01.",
        b"\x80\x02}.",
    ] {
        assert!(refusal(other).problem.contains("the instruction 0x"));
    }
}

#[test]
fn other_arrays_are_refused_with_what_they_are() {
    let replace = |from: &[u8], to: &[u8]| {
        let mut pickle = bytes(PICKLES[1]);
        let at = pickle
            .windows(from.len())
            .position(|part| part == from)
            .expect("there");
        pickle.splice(at..at + from.len(), to.iter().copied());
        refusal(&pickle).problem
    };
    assert_eq!(
        replace(b"u1", b"c8"),
        "expected an array of uint8 (u1), bool, int32, int64, float16, float32 or float64, found c8"
    );
    assert!(replace(b"\x62\x89\x43", b"\x62\x88\x43").contains("found Fortran order"));
    assert!(replace(b"K\x02K\x03K\x04", b"K\x02K\x03K\x05").contains("[2, 3, 5], found 24"));
    assert!(replace(b"K\x02K\x03K\x04", b"K\x02K\x03J\xFF\xFF\xFF\xFF").contains("whole numbers"));
    assert_eq!(
        refusal(b"\x80\x02N.").problem,
        "expected an array at the end, found something else"
    );
    assert_eq!(
        refusal(b"\x80\x02].").problem,
        "expected an array at the end, found an empty list"
    );
    assert!(
        refusal(b"\x80\x02]K\x01a.")
            .problem
            .contains("a list of NumPy arrays")
    );
    assert_eq!(
        refusal(b"\x80\x06N.").problem,
        "expected protocol 2 to 5, found 6"
    );
}

#[test]
fn no_prefix_and_no_changed_byte_panics_or_grows() {
    for pickle in PICKLES {
        let whole = bytes(pickle);
        for length in 0..whole.len() {
            assert!(read(&whole[..length]).is_err(), "{length}");
        }
        for at in 0..whole.len() {
            for flip in [0x01, 0x10, 0x80, 0xFF] {
                let mut changed = whole.clone();
                changed[at] ^= flip;
                // Any array that is read has the length of the original one.
                assert!(
                    read(&changed).is_ok_and(|array| array.bytes.len() == 24)
                        || read(&changed).is_err()
                );
            }
        }
    }
    assert!(
        refusal(&[b'N'; 1000])
            .problem
            .contains("more than 256 instructions")
    );
}

/// Two frames of 2x2 pixels: `pickle.dumps([a, b])` of bool, with the type of the second recalled.
fn list(second: [u8; 4], last: &[u8]) -> Vec<u8> {
    let array = |kind: &[u8], bytes: [u8; 4]| {
        let mut array = b"cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\n".to_vec();
        array.extend(b"K\x00\x85C\x01b\x87R(K\x01K\x02K\x02\x86");
        array.extend(kind);
        array.extend(b"\x89C\x04");
        array.extend(bytes);
        array.extend(b"tb");
        array
    };
    let kind = b"cnumpy\ndtype\nX\x02\0\0\0b1\x89\x88\x87R(K\x03X\x01\0\0\0|NNNJ\xFF\xFF\xFF\xFFJ\xFF\xFF\xFF\xFFK\0tbq\x01";
    let mut pickle = b"\x80\x03]q\x00(".to_vec();
    pickle.extend(array(kind, [0, 1, 1, 0]));
    pickle.extend(array(b"h\x01", second));
    pickle.extend(last);
    pickle
}

#[test]
fn a_list_of_frames_is_one_array() {
    let pickle = list([0, 0, 0, 1], b"e.");
    let array = read(&pickle).expect("a list");
    assert_eq!(array.shape, [2, 2, 2]);
    assert_eq!(*array.bytes, [0, 255, 255, 0, 0, 0, 0, 255]);
    // Appended one at a time, beside a mark that stays.
    assert!(
        refusal(&list([0; 4], b"a."))
            .problem
            .contains("a list to append to")
    );
    assert!(refusal(&list([0; 4], b"e")).problem.contains("cut short"));
    assert!(
        refusal(&list([0; 4], b"eq\x02."))
            .problem
            .contains("while it is empty")
    );
}
