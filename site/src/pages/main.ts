// The script of the pages that are read.
import "../site.css";

import { startPage } from "./page.js";

void startPage();
