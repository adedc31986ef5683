<?php
// Restore a Common Cartridge into a new course of Moodle, and print what it contains then, as JSON. The request is JSON on
// standard input: `config` is the path of Moodle's config.php, `cartridge` that of the file.

require(__DIR__ . '/import.php');
require_once($CFG->dirroot . '/backup/util/includes/restore_includes.php');
chdir($CFG->dirroot . '/backup');  // the converter reads its own files from here, as when a teacher restores a cartridge

// Restore a cartridge and return its quizzes, and the questions of the whole course with their answers.
function restore_cartridge(string $file): array {
    global $DB, $USER;
    $course = create_test_course();
    $name = 'qdot' . uniqid();
    get_file_packer('application/vnd.moodle.backup')->extract_to_pathname($file, make_backup_temp_directory($name));
    $target = backup::TARGET_EXISTING_ADDING;
    $restore = new restore_controller($name, $course->id, backup::INTERACTIVE_NO, backup::MODE_GENERAL, $USER->id, $target);
    $format = $restore->get_format();
    if ($restore->get_status() == backup::STATUS_REQUIRE_CONV) {
        $restore->convert();
    }
    $restore->execute_precheck();
    $messages = $restore->get_precheck_results();
    if ($messages['errors'] ?? []) {
        return ['format' => $format, 'messages' => $messages, 'quizzes' => [], 'questions' => []];
    }
    $restore->execute_plan();
    $restore->destroy();
    $contexts = array_keys(context_course::instance($course->id)->get_child_contexts());
    [$in, $parameters] = $DB->get_in_or_equal([...$contexts, context_course::instance($course->id)->id]);
    $sql = "SELECT q.* FROM {question} q JOIN {question_versions} v ON v.questionid = q.id
              JOIN {question_bank_entries} e ON e.id = v.questionbankentryid
              JOIN {question_categories} c ON c.id = e.questioncategoryid WHERE c.contextid $in ORDER BY q.id";
    $questions = [];
    foreach ($DB->get_records_sql($sql, $parameters) as $question) {
        $answers = array_values($DB->get_records('question_answers', ['question' => $question->id], 'id'));
        $questions[] = ['name' => $question->name, 'type' => $question->qtype, 'text' => $question->questiontext,
            'feedback' => $question->generalfeedback, 'answers' => array_map(fn($answer) => ['text' => $answer->answer,
                'fraction' => (float) $answer->fraction, 'feedback' => $answer->feedback], $answers)];
    }
    $quizzes = [];
    foreach ($DB->get_records('quiz', ['course' => $course->id], 'id') as $quiz) {
        $quizzes[] = ['name' => $quiz->name, 'count' => $DB->count_records('quiz_slots', ['quizid' => $quiz->id])];
    }
    return ['format' => $format, 'messages' => $messages, 'quizzes' => $quizzes, 'questions' => $questions];
}

\core\session\manager::set_user(get_admin());
echo json_encode(['software' => 'Moodle ' . $CFG->release, ...restore_cartridge($request['cartridge'])]);
