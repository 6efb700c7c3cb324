//! Roads from GPX and NMEA: the same road whatever it was recorded in, and faults by their place.
use std::fmt::Write;
use steerwright_control::Error;
use steerwright_control::paths::{
    FixOptions, PointOptions, PoorFixes, RecordedPoints, path_from_recording, read_points,
};

const MARK: FixOptions =
    FixOptions { least_satellites: 5, correction: true, poor: PoorFixes::Mark };

fn read(text: &str) -> Result<RecordedPoints, Error> {
    read_points(text, "road", &FixOptions::default())
}

fn message(text: &str) -> String {
    let error = read(text).unwrap_err();
    assert!(!error.hint().is_empty());
    error.to_string()
}

/// Degrees north and east of a road that bends to the left.
fn road() -> Vec<(f64, f64)> {
    (0..200)
        .map(|k| {
            let s = f64::from(k) * 1.5;
            let angle: f64 = s / 150.0;
            let (east, north) = (150.0 * angle.sin(), 150.0 * (1.0 - angle.cos()));
            (-33.5 + north / 110_900.0, -70.6 + east / 92_900.0)
        })
        .collect()
}

/// A sentence with its checksum.
fn sentence(data: &str) -> String {
    let sum = data.bytes().fold(0_u8, |sum, byte| sum ^ byte);
    format!("${data}*{sum:02X}\n")
}

/// `ddmm.mmmmmmm` and the hemisphere.
fn nmea_angle(degrees: f64, width: usize, sides: [char; 2]) -> String {
    let side = sides[usize::from(degrees < 0.0)];
    let whole = degrees.abs().floor();
    let minutes = (degrees.abs() - whole) * 60.0;
    format!("{whole:0width$}{minutes:010.7},{side}")
}

fn gga(k: usize, (latitude, longitude): (f64, f64), quality: u8, satellites: u8) -> String {
    let (lat, lon) = (nmea_angle(latitude, 2, ['N', 'S']), nmea_angle(longitude, 3, ['E', 'W']));
    sentence(&format!(
        "GNGGA,{:06}.{},{lat},{lon},{quality},{satellites:02},0.8,540.0,M,27.5,M,1.0,0001",
        120_000 + k / 10,
        k % 10
    ))
}

fn rmc(k: usize, (latitude, longitude): (f64, f64), status: char, mode: char) -> String {
    let (lat, lon) = (nmea_angle(latitude, 2, ['N', 'S']), nmea_angle(longitude, 3, ['E', 'W']));
    sentence(&format!(
        "GNRMC,{:06}.{},{status},{lat},{lon},29.2,012.3,010126,,,{mode}",
        120_000 + k / 10,
        k % 10
    ))
}

fn csv() -> String {
    let mut text = "latitude_deg,longitude_deg,altitude_m\n".to_owned();
    for (lat, lon) in road() {
        writeln!(text, "{lat},{lon},567.5").unwrap();
    }
    text
}

fn gpx(points: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<gpx version=\"1.1\" xmlns=\"http://www.topografix.com/GPX/1/1\">\n\
         <trk><name>a &amp; b</name><trkseg>\n{points}</trkseg></trk>\n</gpx>\n"
    )
}

/// How far apart two recordings are, point by point.
fn apart(a: &RecordedPoints, b: &RecordedPoints) -> f64 {
    assert_eq!(a.x_m.len(), b.x_m.len());
    let pairs = a.x_m.iter().zip(&a.y_m).zip(b.x_m.iter().zip(&b.y_m));
    pairs.map(|((ax, ay), (bx, by))| (ax - bx).hypot(ay - by)).fold(0.0, f64::max)
}

#[test]
fn the_format_does_not_matter() {
    let table = read(&csv()).unwrap();
    assert!(table.x_m[199] > 100.0 && table.y_m[199] > 100.0 && table.warnings.is_empty());

    let mut points = String::new();
    for (lat, lon) in road() {
        let _ = writeln!(points, "<trkpt lat=\"{lat}\" lon=\"{lon}\"><ele>567.5</ele></trkpt>");
    }
    assert!(apart(&read(&gpx(&points)).unwrap(), &table) < 1e-9);
    // Routes too, and without a namespace.
    let route = format!("<gpx><rte>{}</rte></gpx>", points.replace("trkpt", "rtept"));
    assert!(apart(&read(&route).unwrap(), &table) < 1e-9);

    // GGA and RMC of each moment are one point; seven digits of a minute are a tenth of a millimetre.
    let mut log = sentence("GNGSV,1,1,00");
    for (k, place) in road().into_iter().enumerate() {
        log += &gga(k, place, 4, 12);
        log += &rmc(k, place, 'A', 'R');
    }
    let nmea = read(&log).unwrap();
    assert!(apart(&nmea, &table) < 1e-3 && nmea.warnings.is_empty(), "{}", apart(&nmea, &table));
    // RMC alone has no altitudes: 568 m of 6371 km are 89 ppm.
    let alone: String =
        road().into_iter().enumerate().map(|(k, place)| rmc(k, place, 'A', 'D')).collect();
    assert!(apart(&read(&alone).unwrap(), &table) < 0.05);
    // With Windows' line ends, and RMC before GGA.
    let mut log = String::new();
    for (k, place) in road().into_iter().enumerate() {
        log += &rmc(k, place, 'A', 'R').replace('\n', "\r\n");
        log += &gga(k, place, 4, 12).replace('\n', "\r\n");
    }
    assert!(apart(&read(&log).unwrap(), &nmea) < 1e-12);

    let recorded = path_from_recording(&log, "drive.nmea", &PointOptions::default()).unwrap();
    let middle = recorded.path.points[recorded.path.points.len() / 2];
    assert!((middle.curvature_per_m - 1.0 / 150.0).abs() < 2e-4, "{middle:?}");
}

#[test]
fn poor_fixes_are_refused_or_marked() {
    let log: String = road()
        .into_iter()
        .enumerate()
        .map(|(k, place)| match k {
            20..30 => gga(k, place, 1, 12),
            50..53 => gga(k, place, 4, 4),
            70 => sentence("GNGGA,120007.0,,,,,0,00,,,M,,M,,"),
            _ => gga(k, place, 5, 5),
        })
        .collect();
    let refused = read(&log).unwrap();
    assert_eq!(refused.x_m.len(), 200 - 14);
    assert_eq!(refused.warnings.len(), 2, "{:?}", refused.warnings);
    assert_eq!(refused.warnings[0], "left out 1 of 200 rows without a position");
    let expected = "left out 13 of 199 fixes with fewer than 5 satellites or no correction \
                    (lines 21, 22, 23, 24, 25 …)";
    assert_eq!(refused.warnings[1], expected);
    let marked = read_points(&log, "road", &MARK).unwrap();
    assert_eq!(marked.x_m.len(), 199);
    assert!(marked.warnings[1].starts_with("used 13 of 199 fixes"), "{:?}", marked.warnings);
    // Without required correction only the satellites count.
    let free = FixOptions { correction: false, ..FixOptions::default() };
    assert_eq!(read_points(&log, "road", &free).unwrap().x_m.len(), 196);

    // A status that contradicts the fix, and a drive without any correction.
    let place = road()[0];
    let log = gga(0, place, 4, 9) + &rmc(0, place, 'V', 'N') + &gga(1, place, 4, 9);
    assert_eq!(read(&log).unwrap().x_m.len(), 1);
    let poor: String =
        road().into_iter().enumerate().map(|(k, place)| gga(k, place, 1, 9)).collect();
    let error = read(&poor).unwrap_err();
    let numbers = Error::PoorFixes {
        file: "road".into(),
        total: 200,
        without: 0,
        poor: 200,
        least_satellites: 5,
    };
    assert_eq!(error, numbers);
    assert!(error.hint().contains("have them marked"), "{}", error.hint());

    let gpx = gpx("<trkpt lat=\"1\" lon=\"2\"><fix>dgps</fix><sat>9</sat></trkpt>\n\
         <trkpt lat=\"1\" lon=\"2.1\"><fix>3d</fix><sat>9</sat></trkpt>\n\
         <trkpt lat=\"1\" lon=\"2.2\"><sat>4</sat></trkpt>\n\
         <trkpt lat=\"1\" lon=\"2.3\"><fix>none</fix></trkpt>\n\
         <trkpt lat=\"1\" lon=\"2.4\"/>\n");
    let points = read(&gpx).unwrap();
    assert_eq!(points.x_m.len(), 2);
    assert!(points.warnings[1].contains("lines 5, 6"), "{:?}", points.warnings);
}

#[test]
fn faults_of_nmea_are_named_by_their_place() {
    let good = gga(0, road()[0], 4, 9);
    let broken = good.replace(",4,09,", ",4,08,");
    assert!(message(&format!("{good}{broken}")).starts_with("road:2:"), "{broken}");
    assert!(message(&broken).contains("the checksum is"), "{}", message(&broken));
    let cut = good.trim_end().rsplit_once('*').unwrap().0.to_owned();
    assert!(message(&cut).contains("without a checksum"));
    for sum in ["ZZ", "", "7", "012", "+5"] {
        let error = message(&format!("{cut}*{sum}"));
        assert!(error.contains("not two hexadecimal digits"), "{error}");
    }
    assert!(message(&format!("{good}garbage\n")).starts_with("road:2:1: a sentence begins with"));
    assert!(message(&sentence("GPGSV,1,1,00")).contains("no sentence GGA or RMC"));
    for (data, expected) in [
        ("GPGGA,1,6060.0,N,01000.0,E,4,9,1,1,M,1,M,,", "the latitude is `6060.0,N`"),
        ("GPGGA,1,5930.0,X,01000.0,E,4,9,1,1,M,1,M,,", "the latitude is `5930.0,X`"),
        ("GPGGA,1,9130.0,N,01000.0,E,4,9,1,1,M,1,M,,", "beyond ±90"),
        ("GPGGA,1,NaN,N,01000.0,E,4,9,1,1,M,1,M,,", "the latitude is `NaN,N`"),
        ("GPGGA,1,5930.0,N,1e3,E,4,9,1,1,M,1,M,,", "the longitude is `1e3,E`"),
        ("GPGGA,1,,,,,4,9,1,1,M,1,M,,", "the fix is valid but has no position"),
        ("GPGGA,1,5930.0,N,01000.0,E,9,9,1,1,M,1,M,,", "the fix quality is `9`"),
        ("GPGGA,1,5930.0,N,01000.0,E,4,many,1,1,M,1,M,,", "the number of satellites is `many`"),
        ("GPGGA,1,5930.0,N,01000.0,E,4,9,1,high,M,1,M,,", "the altitude is `high`"),
        ("GPRMC,1,X,5930.0,N,01000.0,E,1,1,010126,,,A", "the status is `X`"),
        ("GPRMC", "no position"),
    ] {
        let text = sentence(data);
        match read(&text) {
            Err(error) => {
                let text = error.to_string();
                assert!(text.contains(expected) || data == "GPRMC", "{data}: {text}");
            }
            Ok(points) => panic!("{data}: {points:?}"),
        }
    }
    // Columns count from 1, to the field.
    let error = message(&sentence("GPGGA,1,5930.0,N,01000.0,E,9,9,1,1,M,1,M,,"));
    assert!(error.starts_with("road:1:29: "), "{error}");
}

#[test]
fn faults_of_gpx_are_named_by_their_place() {
    let bad = |text: &str, expected: &str| {
        let error = message(text);
        assert!(error.contains(expected), "{error}");
    };
    bad("<gpx><trk></gpx>", "road:1:11: ");
    bad("<gpx", "road:1:");
    bad("<kml/>", "the document is a `kml`, not a `gpx`");
    bad("<gpx/>", "no track and no route with points");
    bad("<gpx><trk><trkseg/></trk></gpx>", "no track and no route with points");
    bad(&gpx("<trkpt lat=\"1\"/>\n"), "road:4:1: the point has no lon");
    bad(&gpx("\n<trkpt lat=\"north\" lon=\"1\"/>\n"), "road:5:1: lat is `north`, not a number");
    bad(&gpx("<trkpt lat=\"NaN\" lon=\"1\"/>\n"), "the latitude is not a number");
    bad(&gpx("<trkpt lat=\"-91\" lon=\"1\"/>\n"), "the latitude is -91, beyond ±90");
    bad(&gpx("<trkpt lat=\"1\" lon=\"1\"><ele>high</ele></trkpt>\n"), "`ele` is not a number");
    bad(&gpx("<trkpt lat=\"1\" lon=\"1\"><fix>good</fix></trkpt>\n"), "`fix` is `good`");
    // What a document type could do to a reader.
    bad("<!DOCTYPE gpx [<!ENTITY a \"b\">]><gpx>&a;</gpx>", "road:");
    let one = gpx("<trkpt lat=\"1\" lon=\"1\"/>\n");
    let error = path_from_recording(&one, "road", &PointOptions::default()).unwrap_err();
    assert!(matches!(error, Error::TooFewPoints { got: 1, need: 4 }), "{error}");
    let two =
        one.replace("</gpx>", "<trk><trkseg><trkpt lat=\"1\" lon=\"1\"/></trkseg></trk></gpx>");
    assert_eq!(read(&two).unwrap().warnings, ["used the first of 2 tracks"]);
}
