//! Tables that end in something else than rows, that are joined of several, or whose rows have no end.

use super::{HEADER, csv, good, good_row, read_one, refused};
use std::fmt::Write;
use std::io::Read;
use steerwright_drivelog::{Error, Inspection, LogFile, LogOptions, inspect};

fn inspected(bytes: &[u8]) -> Inspection {
    inspect(LogFile::of_bytes("drive.csv", bytes), &LogOptions::default()).unwrap()
}

/// Both commands read that many rows, with a warning that has the part.
fn is_read(bytes: Vec<u8>, rows: usize, part: &str) {
    let found = inspected(&bytes);
    assert_eq!(found.groups[0].rows, rows, "{:?}", found.losses);
    assert!(found.losses.iter().any(|loss| loss.contains(part)), "{:?}", found.losses);
    let log = read_one(bytes, &LogOptions::default()).unwrap();
    assert!(log.warnings.iter().any(|loss| loss.contains(part)), "{:?}", log.warnings);
}

fn with_end(end: &str) -> Vec<u8> {
    [good(), end.as_bytes().to_vec()].concat()
}

#[test]
fn zeros_at_the_end_are_left_out_with_a_warning() {
    let zeros = "\0".repeat(5000);
    is_read(with_end(&zeros), 1000, "5000 bytes of 0 at the end");
    is_read(with_end(&format!("{}\n", "\0".repeat(9)).repeat(20)), 1000, "180 bytes of 0");
    let torn = with_end(&format!("10.00,0.0{zeros}"));
    is_read(torn.clone(), 1000, "1002: the row has 2 cells, the header has 4");
    is_read(torn, 1000, "5000 bytes of 0");
    // `1` may have been `15.0`.
    is_read(with_end(&format!("10.00,0.02,0.1,1{zeros}")), 1000, "zeros cut the row off");
    is_read(with_end(&format!("10.00,0.02,0.1,1{zeros}\n")), 1000, "zeros cut the row off");
    // Within a file, what stands beside them in a row may be a part of it.
    let within = with_end(&format!("{zeros}{}\n{}\n", good_row(1000), good_row(1001)));
    is_read(within, 1001, "1 row with zeros among the bytes, as after a loss of power, the first");
    let torn = with_end(&format!("10.00,0.0{zeros}\n{}\n", good_row(1001)));
    is_read(torn, 1001, "1 row with zeros among the bytes, as after a loss of power, the first");
    let often = with_end(&format!("{zeros}{}\n", good_row(1000)).repeat(20));
    assert!(matches!(refused(often, &LogOptions::default()), Error::NotText { line: 1002, .. }));
    let none = refused(vec![0; 5000], &LogOptions::default());
    assert!(matches!(none, Error::NotText { .. }), "{none:?}");
}

#[test]
fn a_quote_that_is_open_in_the_header_is_an_error() {
    let error = refused([b"\"".to_vec(), good()].concat(), &LogOptions::default());
    assert!(matches!(error, Error::OpenQuote { line: 1, .. }), "{error:?}");
}

#[test]
fn the_rows_above_the_values_may_be_repeated() {
    let text = String::from_utf8(good()).unwrap();
    let joined = format!("{text}{HEADER}\n{}\n", good_row(1000));
    is_read(joined.into_bytes(), 1001, "1 row above the values repeated further down");
    let names = "time,roadwheel_angle,yaw_rate,speed\ns,rad,rad/s,m/s\n";
    let body = text.split_once('\n').unwrap().1;
    let joined = format!("{names}{body}\n{names}{}\n", good_row(1000));
    is_read(joined.into_bytes(), 1001, "2 rows above the values repeated further down, the first");
    // Others are another table.
    let other = format!("{text}{}\n{}\n", HEADER.replace("_rad,", "_deg,"), good_row(1000));
    refused(other.into_bytes(), &LogOptions::default());
}

#[test]
fn files_with_byte_order_marks_that_were_joined_are_one_table() {
    let (text, mark) = (String::from_utf8(good()).unwrap(), '\u{feff}');
    let (head, rows) = text.split_once('\n').unwrap();
    let (start, end) = rows.split_at(rows.find("5.00,").unwrap());
    let joined = |between: &str| format!("{mark}{head}\n{start}{mark}{between}{end}").into_bytes();
    is_read(joined(&format!("{head}\n")), 1000, "1 row above the values repeated");
    assert_eq!(inspected(&joined("")).groups[0].rows, 1000);
    assert_eq!(inspected(&joined("")).losses, Vec::<String>::new());
    // The first byte of a mark begins another letter, too.
    let letter = format!("{head}\n{start}\u{f000},0,0,0\n{end}");
    let losses = inspected(letter.as_bytes()).losses;
    assert!(losses[0].contains("`\u{f000}` is not a number"), "{losses:?}");
}

#[test]
fn a_remark_of_several_rows_ends_the_table() {
    is_read(with_end("\nSummary\nrows: 1000\nfastest,15\n"), 1000, "the last 3 rows are not read");
    is_read(with_end("Min,-3,-10,15\nMax,3,10,15\n"), 1000, "the last 2 rows are not read");
    // Rows of values follow.
    for other in [format!("Lap 2\n{}\n", good_row(1000)), "Row\n".repeat(200)] {
        let error = refused(with_end(&other), &LogOptions::default());
        assert!(matches!(error, Error::RaggedRow { line: 1002, .. }), "{error:?}");
    }
}

#[test]
fn an_open_quote_takes_in_no_row_in_silence() {
    let text = csv(&format!("{HEADER},note"), 1000, |k| {
        format!("{},{}", good_row(k), if k == 900 { "\"wet" } else { "" })
    });
    let error = refused(text.clone(), &LogOptions::default());
    assert!(matches!(error, Error::OpenQuote { line: 902, .. }), "{error:?}");
    let found = inspected(&text);
    assert_eq!((found.groups[0].rows, found.losses.len()), (900, 1), "{:?}", found.losses);
}

#[test]
fn messages_quote_the_start_of_a_cell() {
    let long = "x".repeat(100_000);
    let text =
        csv(
            HEADER,
            1000,
            |k| {
                if k == 500 { good_row(k).replace("15.0", &long) } else { good_row(k) }
            },
        );
    let loss = &inspected(&text).losses[0];
    assert!(loss.len() < 300 && loss.contains("xxx…`"), "{loss}");
}

#[test]
fn a_row_of_percent_signs_and_numbers_is_a_row() {
    let header = format!("note,{HEADER},lateral_acceleration_mps2");
    let text = csv(&header, 1000, |k| {
        format!("%,{},{}", good_row(k), if k % 2 == 0 { "0.1" } else { "x" })
    });
    let found = inspected(&text);
    assert_eq!(found.groups[0].rows, 1000, "{:?}", found.losses);
    assert!(found.losses[0].contains("500 of 1000 rows"), "{:?}", found.losses);
}

#[test]
fn names_have_no_decimals_and_stand_below_remarks_of_numbers() {
    let text = String::from_utf8(good()).unwrap();
    let found = inspected(format!("1,2,3,4\nRate,100,Hz,x\n{text}").as_bytes());
    assert_eq!(found.groups[0].clock.as_deref(), Some("time_s"), "{:?}", found.losses);
    let (_, body) = text.split_once('\n').unwrap();
    let found = inspected(format!("x,0.1,-0.2,15.0\n{body}").as_bytes());
    assert_eq!(found.groups[0].channels[0].name, "column_1");
}

#[test]
fn a_row_without_an_end_takes_no_memory_without_end() {
    let start = format!("{HEADER}\n{}\n", good_row(0));
    let forever = start.as_bytes().chain(std::io::repeat(b'7'));
    let found = inspect(LogFile::of_stream("a.csv", forever), &LogOptions::default()).unwrap();
    assert_eq!(found.groups[0].rows, 1);
    assert!(found.losses[0].contains("a row of more than 16 MiB"), "{:?}", found.losses);
}

#[test]
fn many_comments_and_many_columns_are_read() {
    let mut text = String::new();
    (0..120_000).for_each(|k| {
        let _ = writeln!(text, "# remark {k}, of a tool, \"quoted");
    });
    let found = inspected(&[text.into_bytes(), good()].concat());
    assert_eq!((found.groups[0].rows, found.losses.len()), (1000, 0));
    let row = |cell: &str| vec![cell; 200_000].join(",");
    let names: Vec<String> = (0..200_000).map(|k| format!("c{k}")).collect();
    let wide = format!("{}\n{}\n{}\n", names.join(","), row("1.5"), row("2.5"));
    let found = inspected(wide.as_bytes());
    assert_eq!(found.groups[0].channels.len(), 200_000);
}

#[test]
fn quotes_that_take_in_rows_are_an_error_with_both_lines() {
    let rows = |first: usize, last: usize| {
        csv(&format!("{HEADER},note"), 1000, |k| {
            let note = if k == first {
                "\"wet"
            } else if k == last {
                "dry\""
            } else {
                ""
            };
            format!("{},{note}", good_row(k))
        })
    };
    for (first, last) in [(10, 500), (10, 11), (700, 900)] {
        let text = rows(first, last);
        let error = refused(text.clone(), &LogOptions::default());
        let Error::LongQuote { line, last: end, rows, .. } = &error else { panic!("{error:?}") };
        assert_eq!((*line, *end, *rows), (first as u64 + 2, last as u64 + 2, last - first));
        let found = inspected(&text);
        assert_eq!((found.groups[0].rows, found.losses.len()), (first, 1), "{:?}", found.losses);
    }
    // A quote at the start of a row, a comment in quotes, and a table that ends soon.
    for (first, last) in [(10, 500), (940, 990)] {
        for start in ["\"", "\"# "] {
            let text = csv(HEADER, 1000, |k| {
                let row = good_row(k);
                if k == first {
                    format!("{start}{row}")
                } else if k == last {
                    row + "\""
                } else {
                    row
                }
            });
            let error = refused(text, &LogOptions::default());
            assert!(matches!(error, Error::LongQuote { .. }), "{error:?}");
        }
    }
    // Texts of several lines are no rows.
    let text = csv(&format!("{HEADER},note"), 1000, |k| {
        format!("{},\"wet, 3\n1,2,3\na,2,b,4,c\n\"", good_row(k))
    });
    let found = inspected(&text);
    assert_eq!((found.groups[0].rows, found.losses.len()), (1000, 0), "{:?}", found.losses);
}

#[test]
fn messages_quote_the_start_of_a_name() {
    let long = "x".repeat(200_000);
    let o = LogOptions::default();
    let is_short = |text: &str| assert!(text.len() < 1000, "{} bytes", text.len());
    for header in [
        HEADER.replace("steer_rad", &format!("steer_{long}")),
        HEADER.replace("steer_rad", &format!("steer_{long} [xyz]")),
        HEADER.replace("steer_rad", &long),
        HEADER.replace("time_s", &format!("time_{long}")),
    ] {
        let error = refused(csv(&header, 1000, good_row), &o);
        is_short(&error.to_string());
        is_short(&error.hint());
        assert_eq!(error.suggested_unit(), None);
    }
    let header = HEADER.replace("yaw_rate_radps", &format!("yaw_rate_{long}_radps"));
    let text = csv(&header, 1000, |k| {
        if k % 100 == 50 { good_row(k).replace("15.0", "") } else { good_row(k) }
            .replace(",0.1", ",")
    });
    if let Ok(log) = read_one(text, &o) {
        log.warnings.iter().for_each(|warning| is_short(warning));
    }
}

/// Remarks of several lines may be in any column, and their lines may look like rows.
#[test]
fn remarks_of_several_lines_are_cells() {
    for remark in ["lap 1\nbox", "lap 1\nok, box", "gains:\n1,2,3,4\n5,6,7,8\n9,10,11,12"] {
        let first =
            csv(&format!("note,{HEADER}"), 1000, |k| format!("\"{remark}\",{}", good_row(k)));
        let last =
            csv(&format!("{HEADER},note"), 1000, |k| format!("{},\"{remark}\"", good_row(k)));
        for text in [first, last] {
            let found = inspected(&text);
            let read = (found.groups[0].rows, found.losses.len());
            assert_eq!(read, (1000, 0), "{remark}: {:?}", found.losses);
        }
    }
}

#[test]
fn a_quote_in_the_row_of_units_takes_in_no_row() {
    let text = csv(HEADER, 1000, |k| if k == 300 { good_row(k) + "\"" } else { good_row(k) });
    let text = String::from_utf8(text).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    let units = header.split(',').map(|_| "-").collect::<Vec<_>>().join(",");
    let error =
        refused(format!("{header},wheel\n{units},\"\n{rows}").into_bytes(), &LogOptions::default());
    assert!(matches!(error, Error::LongQuote { line: 2, .. }), "{error:?}");
}
