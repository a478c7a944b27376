use super::*;

#[test]
fn a_saved_run_is_drawn_again_to_the_same_bytes() {
    let folder = scratch("plot_saved");
    let path = |name: &str| folder.join(name).display().to_string();
    let (saved, first, second) = (path("run.json"), path("first.png"), path("second.png"));
    let (page, again) = (path("first.html"), path("second.html"));
    let run = ["run", OFFICE, "--set", SHORT, "--save-run", &saved, "--picture", &first, "--report", &page];
    assert_eq!(give(&run).code, 0);
    let plot = give(&["plot", &saved, "--picture", &second, "--report", &again, "--json"]);
    assert_eq!((plot.code, &plot.json()["picture"]), (0, &second.clone().into()), "{}", plot.stderr);
    assert_eq!(std::fs::read(first).unwrap(), std::fs::read(second).unwrap());
    assert_eq!(std::fs::read(page).unwrap(), std::fs::read(again).unwrap());
}

#[test]
fn a_pipeline_is_drawn_before_it_runs() {
    let picture = scratch("plot_preview").join("preview.png");
    let given = give(&["plot", OFFICE, "--picture", picture.to_str().unwrap()]);
    assert_eq!(given.code, 0, "{}", given.stderr);
    let image = image::open(picture).unwrap().into_rgb8();
    // What the scanner sees from the start is shaded green.
    let green = image.pixels().filter(|p| p.0[1] > p.0[0].saturating_add(8) && p.0[1] > p.0[2]).count();
    assert!(green > 1000, "{green}");
}

#[test]
fn what_is_no_saved_run_is_refused_with_the_way_to_get_one() {
    let path = scratch("plot_bad").join("bad.json");
    std::fs::write(&path, "{}").unwrap();
    let given = give(&["plot", path.to_str().unwrap()]);
    assert_eq!(given.code, 2);
    assert!(given.stderr.contains("--save-run"), "{}", given.stderr);
}
