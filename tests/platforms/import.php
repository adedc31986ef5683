<?php
// Shared by moodle.php, moodle_scorm.php and stack.php: read the request, load Moodle, and import files with its own reader.
// The request is JSON on standard input; its `config` is the path of Moodle's config.php.

define('CLI_SCRIPT', true);
$request = json_decode(stream_get_contents(STDIN), true);
require($request['config']);
require_once($CFG->dirroot . '/course/lib.php');
require_once($CFG->dirroot . '/question/format.php');
require_once($CFG->dirroot . '/question/format/xml/format.php');
require_once($CFG->dirroot . '/question/engine/lib.php');

function create_test_course(): stdClass {
    $name = 'qdot ' . uniqid();
    return create_course((object) ['fullname' => $name, 'shortname' => $name, 'category' => 1]);
}

// Return the context of a course's questions: since Moodle 5.0 that of a question bank, an activity; before, the course's.
function get_bank_context(stdClass $course): context {
    $helper = 'core_question\\local\\bank\\question_bank_helper';
    return class_exists($helper) ? $helper::create_default_open_instance($course, 'qdot')->context
        : context_course::instance($course->id);
}

// Import a question bank into a context of a course; return whether that succeeded, and Moodle's messages.
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
        $message = '';
    } catch (moodle_exception $error) {
        [$done, $message] = [false, $error->getMessage() . ' ' . ($error->debuginfo ?? '')];
    }
    return ['done' => $done, 'messages' => trim(ob_get_clean() . $message)];
}
