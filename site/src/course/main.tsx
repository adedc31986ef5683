// The script of the page on which an instructor makes links to rounds.
import "../site.css";

import { showPart } from "../pages/part.js";
import { WithIndex } from "../practice/with-index.js";
import { Maker } from "./maker.js";

await showPart("course", ["In a course", "page.course"], () => (
  <WithIndex>{(index) => <Maker index={index} />}</WithIndex>
));
