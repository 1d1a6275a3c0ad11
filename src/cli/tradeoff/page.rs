//! How does a person look at all points, with the pictures behind them?

use super::Folder;
use super::record::Record;
use crate::cli::Failure;
use base64::Engine;
use serde_json::{Value, json};

const HTML: &str = include_str!("page/page.html");
const CSS: &str = include_str!("page/page.css");
const JS: &str = include_str!("page/page.js");

/// The page: one file that needs no other.
pub(super) fn page(record: &Record, folder: &Folder, pictures: bool) -> Result<String, Failure> {
    let mut data = serde_json::to_value(record).map_err(|e| Failure::Work(e.to_string()))?;
    for (scene, value) in record.scenes.iter().zip(data["scenes"].as_array_mut().into_iter().flatten()) {
        // Pictures of an earlier run may lie there that this one does not show.
        let of = |name: &str| if pictures { picture(folder, &scene.name, name) } else { Value::Null };
        value["reference"]["images"] =
            json!({ "indirect": of("reference.indirect"), "all": of("reference.all") });
        for (point, value) in scene.points.iter().zip(value["points"].as_array_mut().into_iter().flatten()) {
            for (light, flip) in [("all", point.flip), ("indirect", point.flip_indirect)] {
                if let (Some(flip), true) = (flip, value[light].is_object()) {
                    value[light]["flip"] = json!(flip);
                }
            }
            let of = |kind: &str| of(&format!("{}.{kind}", point.id));
            let all = of("all");
            value["images"] = if all.is_null() {
                Value::Null
            } else {
                json!({ "all": all, "indirect": of("indirect"), "error": of("error") })
            };
        }
    }
    // Nothing within the data may end the script that holds it.
    let data = data.to_string().replace('<', "\\u003c");
    Ok(HTML.replace("/*CSS*/", CSS).replace("/*JS*/", JS).replace("/*DATA*/null", &data))
}

/// A picture of the folder as a URL that holds it; null where there is none.
fn picture(folder: &Folder, scene: &str, name: &str) -> Value {
    match std::fs::read(folder.picture(scene, name)) {
        Ok(bytes) => {
            let text = base64::engine::general_purpose::STANDARD.encode(bytes);
            json!(format!("data:image/jpeg;base64,{text}"))
        }
        Err(_) => Value::Null,
    }
}
