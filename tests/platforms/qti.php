<?php
/*
 * Items and the test of a QTI 2.1 package, loaded, held against their schema and scored by the engine whose folder is
 * the first argument; the package is the second. Standard input is a list of responses, [item, {variable: value}],
 * standard output what became of each, as JSON.
 */

require $argv[1] . '/vendor/autoload.php';

use qtism\common\datatypes\files\FileSystemFileManager;
use qtism\common\datatypes\QtiDirectedPair;
use qtism\common\datatypes\QtiFloat;
use qtism\common\datatypes\QtiIdentifier;
use qtism\common\enums\BaseType;
use qtism\common\enums\Cardinality;
use qtism\data\storage\xml\XmlCompactDocument;
use qtism\data\storage\xml\XmlDocument;
use qtism\runtime\common\MultipleContainer;
use qtism\runtime\common\ResponseVariable;
use qtism\runtime\common\State;
use qtism\runtime\rendering\markup\xhtml\XhtmlRenderingEngine;
use qtism\runtime\tests\AssessmentItemSession;
use qtism\runtime\tests\SessionManager;

function document(string $path): XmlDocument
{
    $document = new XmlDocument();
    $document->load($path, true);

    return $document;
}

/** A response as the item declares it: a number, an identifier, or several identifiers or pairs. */
function response($declared, $given): ResponseVariable
{
    $one = match ($declared->getBaseType()) {
        BaseType::FLOAT => fn ($value) => new QtiFloat((float) $value),
        BaseType::IDENTIFIER => fn ($value) => new QtiIdentifier($value),
        BaseType::DIRECTED_PAIR => fn ($value) => new QtiDirectedPair(...explode(' ', $value)),
    };
    $value = $declared->getCardinality() === Cardinality::MULTIPLE
        ? new MultipleContainer($declared->getBaseType(), array_map($one, $given))
        : ($given === null ? null : $one($given));
    $variable = ResponseVariable::createFromDataModel($declared);
    $variable->setValue($value);

    return $variable;
}

/** An item's score and what is told after one more attempt. */
function attempt(AssessmentItemSession $session, array $given): array
{
    $session->beginAttempt();
    $state = new State();
    foreach ($session->getAssessmentItem()->getResponseDeclarations() as $declared) {
        if (array_key_exists($declared->getIdentifier(), $given)) {
            $state->setVariable(response($declared, $given[$declared->getIdentifier()]));
        }
    }
    $session->endAttempt($state);
    $told = [];
    foreach ($session['FEEDBACK'] ?? [] as $identifier) {
        $told[] = $identifier->getValue();
    }

    return ['score' => $session['SCORE']->getValue(), 'told' => $told];
}

function attempts(string $package, array $asked): array
{
    [$item, $givens] = $asked;
    try {
        $loaded = document("$package/items/$item.xml")->getDocumentComponent();
        $session = new AssessmentItemSession($loaded);
        $session->getItemSessionControl()->setMaxAttempts(0);
        $session->beginItemSession();
        $page = (new XhtmlRenderingEngine())->render($loaded)->saveXML();

        return ['page' => $page, 'attempts' => array_map(fn ($given) => attempt($session, $given), $givens)];
    } catch (Throwable $error) {
        return ['error' => get_class($error) . ': ' . $error->getMessage()];
    }
}

/** The items that a student is given, in their order, and how often the first may be tried. */
function drawn(string $package): array
{
    $test = XmlCompactDocument::createFromXmlAssessmentTestDocument(document("$package/test.xml"));
    $manager = new SessionManager(new FileSystemFileManager());
    $session = $manager->createAssessmentTestSession($test->getDocumentComponent());
    $session->beginTestSession();
    $items = [];
    foreach ($session->getRoute()->getAllRouteItems() as $each) {
        $items[] = $each->getAssessmentItemRef()->getIdentifier();
    }

    return ['items' => $items, 'attempts' => $session->getCurrentRemainingAttempts()];
}

$asked = json_decode(stream_get_contents(STDIN), true);
$scored = array_map(fn ($each) => attempts($argv[2], $each), $asked);
try {
    $tests = [drawn($argv[2]), drawn($argv[2])];
} catch (Throwable $error) {
    $tests = ['error' => get_class($error) . ': ' . $error->getMessage()];
}
echo json_encode(['items' => $scored, 'tests' => $tests]);
