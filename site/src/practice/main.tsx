// The practice page's script.
import "../site.css";

import { render } from "preact";

import { startPage } from "../pages/page.js";
import { Practice } from "./practice.js";

startPage();
const place = document.getElementById("practice");
if (place) {
  place.textContent = "";
  render(<Practice />, place);
}
