<?php
// The start of moodle.php, moodle_scorm.php and stack.php: load Moodle, and import our file with its own reader. The request
// is JSON on standard input; its `config` is the path of Moodle's config.php.

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

// Return where a course has its questions: since Moodle 5.0 in an activity, the question bank, and before in the course.
function bank_context(stdClass $course): context {
    $helper = 'core_question\\local\\bank\\question_bank_helper';
    return class_exists($helper) ? $helper::create_default_open_instance($course, 'qdot')->context
        : context_course::instance($course->id);
}

// Import a question bank into a context of a course; return whether that was done, and what Moodle said.
function import(string $file, stdClass $course, context $context): array {
    $format = new qformat_xml();
    $format->setContexts([$context]);
    $format->setCourse($course);
    $format->setFilename($file);
    $format->setRealfilename(basename($file));
    $format->setMatchgrades('error');
    $format->setCatfromfile(true);
    $format->setContextfromfile(false);
    $format->setStoponerror(true);
    $format->setCategory(question_get_default_category($context->id, true));
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
