<?php
// Moodle made ready, and our file imported by its own reader: what moodle.php, moodle_scorm.php and stack.php begin with. The request is JSON
// on standard input; its `config` is Moodle's config.php.

define('CLI_SCRIPT', true);
$request = json_decode(stream_get_contents(STDIN), true);
require($request['config']);
require_once($CFG->dirroot . '/course/lib.php');
require_once($CFG->dirroot . '/question/format.php');
require_once($CFG->dirroot . '/question/format/xml/format.php');
require_once($CFG->dirroot . '/question/engine/lib.php');

function a_course(): stdClass {
    $name = 'qdot ' . uniqid();
    return create_course((object) ['fullname' => $name, 'shortname' => $name, 'category' => 1]);
}

// Import a question bank; return whether that was done, and what was said of it.
function import(string $file, stdClass $course): array {
    $context = context_course::instance($course->id);
    $format = new qformat_xml();
    $format->setContexts([$context]);
    $format->setCourse($course);
    $format->setFilename($file);
    $format->setRealfilename(basename($file));
    $format->setMatchgrades('error');
    $format->setCatfromfile(true);
    $format->setContextfromfile(false);
    $format->setStoponerror(true);
    $format->setCategory(question_make_default_categories([$context]));
    $format->set_display_progress(false);
    ob_start();
    try {
        $done = $format->importpreprocess() && $format->importprocess() && $format->importpostprocess();
        $said = '';
    } catch (moodle_exception $error) {
        [$done, $said] = [false, $error->getMessage() . ' ' . ($error->debuginfo ?? '')];
    }
    return ['done' => $done, 'said' => trim(ob_get_clean() . $said)];
}
