//! What FMI 2.0.5, section 2.3, asks of an archive, and what it carries besides the model.
#![allow(clippy::unwrap_used, clippy::panic)]

use crate::support;

use model_description::{Causality, ModelDescription};
use std::collections::{BTreeMap, BTreeSet};
use steerwright_packaging::{Binary, Error, Fmu};
use support::{AWKWARD, document, files, packed, text};

const EXTRA: &str = "extra/io.github.steerwright";

/// An entry of the zip's central directory (APPNOTE 4.3.12), as far as FMI cares.
struct Entry {
    name: String,
    needed: u16,
    flags: u16,
    method: u16,
    stamp: u32,
    mode: u32,
}

/// Read by hand: what a zip library makes of it is not what another importer sees.
fn central_directory(zip: &[u8]) -> Vec<Entry> {
    let u16_at = |at: usize| u16::from_le_bytes(zip[at..at + 2].try_into().unwrap());
    let u32_at = |at: usize| u32::from_le_bytes(zip[at..at + 4].try_into().unwrap());
    let end = zip.len() - 22;
    assert_eq!(u32_at(end), 0x0605_4b50, "the archive ends in a comment");
    assert_eq!((u16_at(end + 4), u16_at(end + 6)), (0, 0), "split over disks");
    let mut at = u32_at(end + 16) as usize;
    (0..u16_at(end + 10))
        .map(|_| {
            assert_eq!(u32_at(at), 0x0201_4b50);
            let length = usize::from(u16_at(at + 28));
            let entry = Entry {
                name: String::from_utf8(zip[at + 46..at + 46 + length].to_vec()).unwrap(),
                needed: u16_at(at + 6) & 0xff,
                flags: u16_at(at + 8),
                method: u16_at(at + 10),
                stamp: u32_at(at + 12),
                mode: u32_at(at + 38) >> 16,
            };
            at += 46 + length + usize::from(u16_at(at + 30)) + usize::from(u16_at(at + 32));
            entry
        })
        .collect()
}

#[test]
fn any_zip_program_can_open_it() {
    for fmu in Fmu::ALL {
        let packed = packed(fmu);
        let entries = central_directory(&packed.bytes);
        for entry in &entries {
            let name = &entry.name;
            assert!(entry.needed <= 20, "{name} needs version {}", entry.needed);
            assert!(matches!(entry.method, 0 | 8), "{name}: method {}", entry.method);
            assert_eq!(entry.flags & 1, 0, "{name} is encrypted");
            assert!(entry.method == 8 || entry.flags & 8 == 0, "{name}: stored with bit 3");
            assert_eq!(entry.mode & 0o170_000, 0o100_000, "{name} is no plain file");
            assert!(name.is_ascii() && !name.contains('\\') && !name.starts_with('/'), "{name}");
            assert!(!name.split('/').any(|part| part == ".." || part.is_empty()), "{name}");
            assert_eq!(entry.stamp, entries[0].stamp, "{name} has a time of its own");
        }
        let names: Vec<&str> = entries.iter().map(|e| e.name.as_str()).collect();
        assert_eq!(names[0], "modelDescription.xml");
        assert!(names[1..].is_sorted_by(|a, b| a < b), "{names:?}");
        for name in ["model.png", "documentation/index.html", "documentation/licenses/license.txt"]
        {
            assert!(names.contains(&name), "{name}");
        }
    }
}

#[test]
fn the_same_inputs_give_the_same_bytes_whatever_the_file_is_called() {
    for fmu in Fmu::ALL {
        let at = |file| {
            steerwright_packaging::package(&document(fmu), file, support::LINUX, Some(0.01), None)
                .unwrap()
                .bytes
        };
        assert!(at("a/plant.json") == at("/another/folder/b.json"), "{fmu:?}");
    }
}

#[test]
fn pictures_are_png() {
    for fmu in Fmu::ALL {
        let files = files(&packed(fmu));
        assert_eq!(files["model.png"], files["terminalsAndIcons/icon.png"]);
        for (name, bytes) in files.iter().filter(|(name, _)| name.ends_with(".png")) {
            assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n"), "{name}");
        }
    }
}

#[test]
fn provenance_reaches_programs_and_people() {
    let packed = packed(Fmu::IdentifiedPlant);
    let files = files(&packed);
    let document = document(Fmu::IdentifiedPlant);
    let hash = steerwright_formats::sha256_hex(document.as_bytes());

    let json: serde_json::Value =
        serde_json::from_str(&text(&files, &format!("{EXTRA}/provenance.json"))).unwrap();
    assert_eq!(json["schema"], "steerwright/provenance/1");
    assert_eq!(json["document"]["name"], AWKWARD);
    assert_eq!(json["document"]["sha256"], hash);
    assert_eq!(json["sources"][0]["sha256"], "ab".repeat(32));
    assert_eq!(json["options"]["order"], "auto");
    let fact = |key: &str| {
        let facts = json["evidence"].as_array().unwrap();
        facts.iter().find(|f| f["key"] == key).unwrap_or_else(|| panic!("no {key}"))["value"]
            .clone()
    };
    assert_eq!(fact("fit_held_out"), 87.654_321);
    assert_eq!(fact("quality"), "pass");

    let xml = text(&files, "modelDescription.xml");
    let xml = roxmltree::Document::parse(&xml).unwrap();
    let tool = xml.descendants().find(|n| n.has_tag_name("Tool")).unwrap();
    assert_eq!(tool.attribute("name"), Some("steerwright"));
    // fmi2Annotation.xsd allows one element.
    let children: Vec<_> = tool.children().filter(roxmltree::Node::is_element).collect();
    assert_eq!(children.len(), 1);
    let find = |tag: &str| children[0].descendants().find(|n| n.has_tag_name(tag)).unwrap();
    assert_eq!(find("Document").attribute("sha256"), Some(hash.as_str()));
    assert_eq!(find("Source").attribute("name"), Some("drive <1>.csv"));
    let fit = children[0].descendants().find(|n| n.attribute("key") == Some("fit_held_out"));
    assert_eq!(fit.unwrap().attribute("value"), Some("87.654321"));

    let page = text(&files, "documentation/index.html");
    assert!(page.contains("87.65 %") && page.contains(&hash) && page.contains("fit to design on"));
    assert!(page.contains("drive &lt;1&gt;.csv") && !page.contains("<b>&amp;"), "{page}");
    assert!(page.contains("(0.573\u{a0}deg)"), "the steering offset is its start value");
    // Our own reader takes the annotation back.
    let read = ModelDescription::from_xml(&text(&files, "modelDescription.xml")).unwrap();
    assert_eq!(read.vendor_annotations.len(), 1);
}

#[test]
fn the_page_loads_nothing_from_elsewhere_and_its_links_lead_somewhere() {
    for fmu in Fmu::ALL {
        let files = files(&packed(fmu));
        let page = text(&files, "documentation/index.html");
        for link in ["src=\"", "href=\""].iter().flat_map(|word| page.split(word).skip(1)) {
            let target = link.split('"').next().unwrap();
            let name = match target.strip_prefix("../") {
                Some(name) => name.to_owned(),
                None => format!("documentation/{target}"),
            };
            assert!(files.contains_key(&name), "{fmu:?}: {target} is not in the archive");
        }
        for word in ["http:", "https:", "<script", "@import", "url("] {
            assert!(!page.contains(word), "{fmu:?}: {word}");
        }
        // Limits, for those who set a value by hand.
        assert!(page.contains("≥\u{a0}0"), "{fmu:?}");
    }
}

/// Each terminal's rule and its members with their causality.
type Terminals = BTreeMap<String, (String, BTreeMap<String, Causality>)>;

fn terminals(fmu: Fmu) -> Terminals {
    let packed = packed(fmu);
    let files = files(&packed);
    let xml = text(&files, "terminalsAndIcons/terminalsAndIcons.xml");
    let xml = roxmltree::Document::parse(&xml).unwrap();
    assert_eq!(xml.root_element().attribute("fmiVersion"), Some("3.0"));
    xml.descendants()
        .filter(|n| n.has_tag_name("Terminal"))
        .map(|terminal| {
            let mut members = BTreeMap::new();
            for node in terminal.children().filter(roxmltree::Node::is_element) {
                if let Some(icon) = node.attribute("iconBaseName") {
                    assert!(files.contains_key(&format!("terminalsAndIcons/{icon}.png")));
                    continue;
                }
                let name = node.attribute("variableName").unwrap();
                // `signal` is for inputs, outputs and parameters alone.
                let variable = packed.description.variable(name).unwrap();
                members
                    .insert(node.attribute("memberName").unwrap().to_owned(), variable.causality);
            }
            let rule = terminal.attribute("matchingRule").unwrap().to_owned();
            (terminal.attribute("name").unwrap().to_owned(), (rule, members))
        })
        .collect()
}

#[test]
fn terminals_close_the_steering_loop() {
    let path = terminals(Fmu::ReferencePath);
    let pid = terminals(Fmu::LateralPid);
    for plant in [Fmu::IdentifiedPlant, Fmu::BicyclePlant].map(terminals) {
        for (from, to, name) in [
            (&plant, &path, "pose"),
            (&plant, &pid, "pose"),
            (&path, &pid, "guidance"),
            (&pid, &plant, "steering"),
        ] {
            let ((rule, outputs), (other, inputs)) = (&from[name], &to[name]);
            assert_eq!(rule, other);
            assert!(outputs.values().all(|c| *c == Causality::Output), "{name}");
            assert!(inputs.values().all(|c| *c == Causality::Input), "{name}");
            let (outputs, inputs): (BTreeSet<_>, BTreeSet<_>) =
                (outputs.keys().collect(), inputs.keys().collect());
            assert!(inputs.is_subset(&outputs) && !inputs.is_empty(), "{name}");
            assert!(rule == "bus" || inputs == outputs, "{name}: a plug matches in full or not");
        }
    }
    assert_eq!(path["pose"].1.len(), 3);
    let estimator = terminals(Fmu::PoseEstimator);
    for (name, members) in [("pose", 3), ("sideslip", 1)] {
        let (outputs, inputs) = (&estimator[name].1, &path[name].1);
        assert!(outputs.keys().eq(inputs.keys()) && inputs.len() == members, "{name}");
    }
}

#[test]
fn each_platform_has_its_folder_and_its_standing() {
    let folders = [
        ("linux64", "so"),
        ("win64", "dll"),
        ("darwin64", "dylib"),
        ("aarch64-linux", "so"),
        ("aarch64-darwin", "dylib"),
        ("win32", "dll"),
    ];
    let binaries = folders.map(|(platform, _)| Binary { platform, bytes: platform.as_bytes() });
    let packed = steerwright_packaging::package(
        &document(Fmu::LateralPid),
        "pid.json",
        &binaries,
        None,
        None,
    );
    let files = files(&packed.unwrap());
    let page = text(&files, "documentation/index.html");
    for (folder, extension) in folders {
        let name = format!("binaries/{folder}/LateralPid.{extension}");
        assert_eq!(text(&files, &name), folder);
        let row = page.split("<tr>").find(|row| row.contains(&name)).unwrap();
        // What was never run does not say that it was.
        let never = folder.contains("darwin") || folder == "win32";
        assert_eq!(row.contains("never"), never, "{row}");
    }
    // The order in which libraries are given does not matter.
    let mut other = binaries;
    other.reverse();
    let again =
        steerwright_packaging::package(&document(Fmu::LateralPid), "pid.json", &other, None, None)
            .unwrap();
    assert!(support::files(&again) == files);
}

#[test]
fn a_platform_that_no_importer_looks_for_is_refused() {
    let pack = |binaries: &[Binary<'_>]| {
        steerwright_packaging::package(&document(Fmu::LateralPid), "pid.json", binaries, None, None)
    };
    let linux = Binary { platform: "linux64", bytes: b"" };
    let error = pack(&[Binary { platform: "x86_64-linux", bytes: b"" }]).unwrap_err();
    assert!(matches!(&error, Error::Platform { platform } if platform == "x86_64-linux"));
    assert!(error.hint().contains("linux64"));
    assert!(matches!(pack(&[linux, linux]).unwrap_err(), Error::TwoBinaries { .. }));
    assert!(matches!(pack(&[]).unwrap_err(), Error::NoBinary { .. }));
}
