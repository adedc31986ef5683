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
require_once($CFG->dirroot . '/backup/util/includes/restore_includes.php');
require_once($CFG->dirroot . '/mod/quiz/locallib.php');

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
    $format->setCategory(question_get_default_category($context->id, true) ?: question_make_default_categories([$context]));
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

// Restore a quiz from a backup and start an attempt; return its settings, slots and context.
function restore_quiz(string $file, stdClass $course): array {
    global $DB, $USER;
    $name = 'qdot' . uniqid();
    $folder = make_backup_temp_directory($name);
    get_file_packer('application/vnd.moodle.backup')->extract_to_pathname($file, $folder);
    $target = backup::TARGET_EXISTING_ADDING;
    $restore = new restore_controller($name, $course->id, backup::INTERACTIVE_NO, backup::MODE_GENERAL, $USER->id, $target);
    $is_valid = $restore->execute_precheck();
    $messages = $restore->get_precheck_results();
    if (!$is_valid) {
        return ['done' => false, 'messages' => $messages];
    }
    $restore->execute_plan();
    $restore->destroy();
    $quiz = $DB->get_record('quiz', ['course' => $course->id], '*', MUST_EXIST);
    $context = context_module::instance(get_coursemodule_from_instance('quiz', $quiz->id)->id);
    $attempt = quiz_prepare_and_start_new_attempt(\mod_quiz\quiz_settings::create($quiz->id, $USER->id), 1, null);
    $usage = question_engine::load_questions_usage_by_activity($attempt->uniqueid);
    $slots = [];
    foreach ($usage->get_slots() as $slot) {
        $question = $usage->get_question($slot);
        $category = $DB->get_field('question_categories', 'name', ['id' => $question->category]);
        $slots[] = ['points' => $usage->get_question_max_mark($slot), 'question' => $question->name, 'category' => $category];
    }
    $item = $DB->get_record('grade_items', ['itemmodule' => 'quiz', 'iteminstance' => $quiz->id]);
    return ['done' => true, 'messages' => $messages, 'quiz' => (array) $quiz, 'slots' => $slots, 'highest' => $item->grademax,
        'context' => $context];
}
