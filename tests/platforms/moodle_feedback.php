<?php
// Submit notebooks to an assignment in Moodle, download them, upload feedback files, and print the results as JSON:
// `php moodle_feedback.php < request.json`, called by moodle.py.
//
// The first request: `config` (path of Moodle's config.php), `students` ([{id, name, email, notebook}], without notebooks if nobody
// submits) and `download` (path of the zip to write); the response has the id of the assignment's module and, by email address, the participants' numbers, which
// are in Moodle's grading worksheet. The second: `config`, `module` and `feedback` (path of the zip to upload); the response has
// the content of each student's feedback files, by email address and name.

require(__DIR__ . '/import.php');
require_once($CFG->dirroot . '/course/modlib.php');
require_once($CFG->dirroot . '/mod/assign/locallib.php');
require_once($CFG->dirroot . '/mod/assign/feedback/file/importziplib.php');
require_once($CFG->dirroot . '/user/lib.php');

// Create an assignment that takes files and gives feedback files; return the id of its module.
function create_file_assignment(stdClass $course): int {
    $off = array_fill_keys(['submissiondrafts', 'requiresubmissionstatement', 'sendnotifications', 'sendlatenotifications',
        'sendstudentnotifications', 'duedate', 'cutoffdate', 'gradingduedate', 'allowsubmissionsfromdate', 'teamsubmission',
        'requireallteammemberssubmit', 'blindmarking', 'markingworkflow', 'markingallocation', 'teamsubmissiongroupingid',
        'assignsubmission_file_maxsizebytes'], 0);
    $module = create_module((object) ($off + ['modulename' => 'assign', 'course' => $course->id, 'section' => 0, 'visible' => 1,
        'name' => 'Homework', 'introeditor' => ['text' => '', 'format' => FORMAT_HTML, 'itemid' => 0], 'grade' => 100,
        'cmidnumber' => '', 'assignsubmission_file_enabled' => 1, 'assignsubmission_file_maxfiles' => 2,
        'assignsubmission_file_filetypes' => '', 'assignfeedback_file_enabled' => 1, 'attemptreopenmethod' => 'none',
        'maxattempts' => -1]));
    return $module->coursemodule;
}

function load_assignment(int $module): assign {
    [$course, $cm] = get_course_and_cm_from_cmid($module, 'assign');
    return new assign(context_module::instance($module), $cm, $course);
}

// Enrol a user by the plugin for manual enrolments, which a new course doesn't have everywhere.
function enrol_as_student(stdClass $course, int $user): void {
    global $DB;
    $plugin = enrol_get_plugin('manual');
    $instance = $DB->get_record('enrol', ['courseid' => $course->id, 'enrol' => 'manual'])
        ?: $DB->get_record('enrol', ['id' => $plugin->add_instance($course, ['status' => ENROL_INSTANCE_ENABLED])]);
    $role = $DB->get_field('role', 'id', ['shortname' => 'student'], MUST_EXIST);
    $plugin->enrol_user($instance, $user, $role);
}

// Enrol a student, and submit the student's notebook.
function submit_notebook(assign $assignment, array $student): void {
    global $DB;
    $names = explode(' ', $student['name'], 2);
    $user = ['username' => $student['id'] . uniqid(), 'auth' => 'manual', 'confirmed' => 1, 'mnethostid' => 1,
        'firstname' => $names[0], 'lastname' => $names[1] ?? '-', 'email' => uniqid() . $student['email']];
    $id = user_create_user($user, false, false);
    $DB->set_field('user', 'email', $student['email'], ['id' => $id]);
    enrol_as_student($assignment->get_course(), $id);
    $submission = $assignment->get_user_submission($id, true);
    $DB->set_field('assign_submission', 'status', ASSIGN_SUBMISSION_STATUS_SUBMITTED, ['id' => $submission->id]);
    $place = ['contextid' => $assignment->get_context()->id, 'component' => 'assignsubmission_file', 'userid' => $id,
        'filearea' => 'submission_files', 'itemid' => $submission->id, 'filepath' => '/', 'filename' => 'hw.ipynb'];
    if (!$student['notebook']) {
        return;
    }
    get_file_storage()->create_file_from_pathname($place, $student['notebook']);
    $DB->insert_record('assignsubmission_file',
        ['assignment' => $assignment->get_instance()->id, 'submission' => $submission->id, 'numfiles' => 1]);
}

// Write Moodle's own download of all submissions.
function write_download(assign $assignment, string $path): void {
    $downloader = new class($assignment) extends \mod_assign\downloader {
        public function get_files(): array {
            return $this->load_filelist() ? $this->filesforzipping : [];
        }
    };
    get_file_packer('application/zip')->archive_to_pathname($downloader->get_files(), $path);
}

// Upload feedback files as "Upload feedback files in a zip" does; return the stored files by email and name.
function upload_feedback(assign $assignment, string $path): array {
    global $USER;
    $place = ['contextid' => context_user::instance($USER->id)->id, 'component' => 'user', 'filearea' => 'draft',
        'itemid' => file_get_unused_draft_itemid(), 'filepath' => '/', 'filename' => 'feedback.zip'];
    $zip = get_file_storage()->create_file_from_pathname($place, $path);
    $importer = new assignfeedback_file_zip_importer();
    $importer->extract_files_from_zip($zip, $assignment->get_context()->id);
    ob_start();
    $importer->import_zip_files($assignment, $assignment->get_feedback_plugin_by_type('file'));
    ob_end_clean();
    $feedback = [];
    foreach ($assignment->list_participants(0, false) as $user) {
        $grade = $assignment->get_user_grade($user->id, false);
        $files = $grade ? get_file_storage()->get_area_files($assignment->get_context()->id, 'assignfeedback_file',
            'feedback_files', $grade->id, 'id', false) : [];
        foreach ($files as $file) {
            $feedback[$user->email][$file->get_filename()] = $file->get_content();
        }
    }
    return $feedback;
}

\core\session\manager::set_user(get_admin());
if ($request['feedback'] ?? null) {
    $assignment = load_assignment($request['module']);
} else {
    $assignment = load_assignment(create_file_assignment(create_test_course()));
}
$PAGE->set_context($assignment->get_context());
$PAGE->set_cm($assignment->get_course_module());
$PAGE->set_url('/');
if ($request['feedback'] ?? null) {
    $response = ['feedback' => upload_feedback($assignment, $request['feedback'])];
} else {
    array_map(fn($student) => submit_notebook($assignment, $student), $request['students']);
    if ($request['download']) {
        write_download($assignment, $request['download']);
    }
    $users = $assignment->list_participants(0, false);
    $numbers = array_map(fn($user) => $assignment->get_uniqueid_for_user($user->id), $users);
    $response = ['module' => (int) $assignment->get_course_module()->id,
        'numbers' => array_combine(array_column($users, 'email'), $numbers)];
}
echo json_encode($response, JSON_THROW_ON_ERROR);
